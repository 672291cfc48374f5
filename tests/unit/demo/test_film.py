# SPDX-License-Identifier: BSD-3-Clause
"""The films of a session: captions stand as long as they should, and the video has its sound."""

import re
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from demo import film, video
from demo.film import Caption, Shot, caption_at, framed, thinned

BLUE, RED = (0, 0, 255), (255, 0, 0)


def shot(time, colour=BLUE):
    return Shot(time, Image.new("RGB", (320, 180), colour))


@pytest.mark.parametrize(
    ("time", "words"), [(0.9, ""), (1.0, "one"), (3.9, "one"), (4.0, "two"), (7.1, "")]
)
def test_the_newest_words_stand_for_three_seconds(time, words):
    assert caption_at([Caption(1.0, "one"), Caption(4.0, "two")], time, 3.0) == words


def test_no_more_pictures_are_taken_than_the_rate_allows():
    times = [0.0, 0.1, 0.6, 1.0, 1.2, 3.0]
    assert [s.time for s in thinned([shot(t) for t in times], 2.0)] == [0.0, 0.6, 1.2, 3.0]


def test_words_stand_in_a_band_below_the_picture_and_are_cut_where_they_are_too_long():
    plain, said, long = (
        np.asarray(framed(shot(0.0).image, words, 321)) for words in ("", "pull more", "pull " * 50)
    )
    height = plain.shape[0] - film.BAND
    assert plain.shape[0] % 2 == 0 and abs(height - 181) <= 1
    assert (plain[:180] == BLUE).all() and (said[:180] == plain[:180]).all()
    assert (said[182:] != plain[182:]).any()
    assert (long[:, -10:][182:] == film.DARK).all()  # nothing runs into the edge


@pytest.mark.parametrize(
    ("topic", "content", "words"),
    [
        (film.UTTERANCE, {"command": "stop", "transcript": "stop"}, '"stop"'),
        (film.UTTERANCE, {"command": "", "transcript": "the beds"}, '"the beds": no command'),
        (film.DEVICE, {"phrase": "light on", "is_done": True}, "light on: done"),
        (film.DEVICE, {"phrase": "light on", "is_done": False}, ""),
        (
            film.EVENT,
            {"kind": "accepted", "caller": "/pedal", "command": "pull more", "message": "pulls"},
            "by pedal: pull more (pulls)",
        ),
        (
            film.EVENT,
            {"kind": "accepted", "caller": "/demo_1", "command": "pull less", "message": "0.2 N"},
            "by hand: pull less (0.2 N)",
        ),
        (film.EVENT, {"kind": "accepted", "caller": "/voice_assist", "command": "stop"}, ""),
        (film.EVENT, {"kind": "halted", "caller": "/pedal", "command": "stop"}, ""),
    ],
)
def test_each_way_of_commanding_has_its_caption(topic, content, words):
    assert film.caption_of(topic, SimpleNamespace(**content)) == words


def test_the_video_has_pictures_and_sound_of_the_same_length(tmp_path, monkeypatch):
    shots = [shot(10.0), shot(11.0, RED), shot(12.5)]
    monkeypatch.setattr(video, "read_session", lambda _: (shots, [Caption(10.2, "stop")]))
    tone = (8000 * np.sin(np.arange(40_000) / 5)).astype(np.int16)
    monkeypatch.setattr(video, "sound_of", lambda *_: (tone, 16_000))
    file = tmp_path / "film.mp4"
    assert video.write_video(tmp_path / "session.mcap", file) == pytest.approx(2.5)
    printed = subprocess.run(
        [video.encoder(), "-i", str(file)], capture_output=True, text=True
    ).stderr
    seconds = float(re.search(r"Duration: 00:00:([\d.]+)", printed)[1])
    assert seconds == pytest.approx(2.5, abs=0.2)
    assert "Video: h264" in printed and "Audio: aac" in printed and "960x592" in printed


def test_a_recording_without_pictures_and_a_failing_encoder_are_named(tmp_path, monkeypatch):
    monkeypatch.setattr(video, "read_session", lambda _: ([shot(1.0)], []))
    with pytest.raises(RuntimeError, match=r"1 pictures in .*record them with --film"):
        video.write_video(tmp_path / "session.mcap", tmp_path / "film.mp4")
    monkeypatch.setattr(video, "read_session", lambda _: ([shot(1.0), shot(2.0)], []))
    monkeypatch.setattr(video, "sound_of", lambda *_: (np.zeros(16_000, np.int16), 16_000))
    with pytest.raises(RuntimeError, match="ffmpeg: "):
        video.write_video(tmp_path / "session.mcap", tmp_path / "missing" / "film.mp4")
