# SPDX-License-Identifier: BSD-3-Clause
"""A sound file is read right, or refused in one sentence before a word of it was heard."""

import numpy as np
import pytest
import soundfile

from voice_assist.audio.sound_file import check_sound, read_sound
from voice_assist.audio.wav_file import WavFile
from voice_assist.errors import AudioError
from voice_assist.types import RATE

TONE = 0.3 * np.sin(2 * np.pi * 440 * np.arange(22_050 * 3) / 22_050)


def written(tmp_path, name, sound=TONE, rate=22_050, **how):
    path = tmp_path / name
    soundfile.write(path, sound, rate, **how)
    return path


def damaged(path, at=0.5, zeros=200):
    content = bytearray(path.read_bytes())
    start = round(at * len(content))
    content[start : start + zeros] = bytes(zeros)
    path.write_bytes(content)
    return path


def cut(path, share=0.6):
    path.write_bytes(path.read_bytes()[: round(share * path.stat().st_size)])
    return path


def heard(path):
    """All of a file, as fast as it is read."""

    def wait(seconds):
        raise AssertionError(f"waited for {seconds} s")

    with WavFile(path, lambda: 0.0, wait, speed=0.0) as source:
        return np.concatenate([frame.samples for frame in source])


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("gsm.wav", {"subtype": "GSM610"}),  # cannot be sought in
        ("g721.au", {"subtype": "G721_32"}),
        ("adpcm.wav", {"subtype": "IMA_ADPCM"}),
        ("tone.mp3", {"format": "MP3"}),
        ("float.wav", {"subtype": "FLOAT"}),
        ("tone.aiff", {}),
        ("tone.flac", {}),
        ("tone.ogg", {}),
    ],
)
def test_every_format_is_read_by_both_ways(tmp_path, name, how):
    path = written(tmp_path, name, **how)
    for sound in (read_sound(path), heard(path)):
        assert len(sound) == pytest.approx(3 * RATE, abs=2000)
        middle = sound[RATE : 2 * RATE]
        assert np.abs(np.fft.rfft(middle * np.hanning(RATE))).argmax() == pytest.approx(440, abs=2)
        assert np.std(middle) == pytest.approx(0.212, abs=0.02)


def with_value(value, at=30_000):
    sound = TONE.copy()
    sound[at] = value
    return sound


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: damaged(written(p, "a.flac")), r"damaged after 1\.\d\d s"),
        (lambda p: cut(written(p, "a.flac")), r"damaged after 1\.\d\d s"),
        (lambda p: cut(written(p, "a.mp3", format="MP3")), r"cut off after 1\.\d\d s of 3\.00 s"),
        (lambda p: cut(written(p, "a.ogg")), "holds no sound, or is cut off"),
        (
            lambda p: written(p, "a.wav", with_value(np.nan), subtype="FLOAT"),
            r"values that are no numbers, from 1\.\d\d s on",
        ),
        (
            lambda p: written(p, "a.wav", with_value(-np.inf), subtype="DOUBLE"),
            "values that are no numbers",
        ),
        (
            lambda p: written(p, "a.wav", 32_767 * TONE, subtype="FLOAT"),
            r"values up to 98\d\d\.\d\d?, allowed: -1 to 1, as of float samples, from 0\.00 s on",
        ),
        (lambda p: written(p, "a.wav", rate=999), "sample rate 999 Hz, allowed: 1000 to 768000 Hz"),
        (lambda p: p / "a.wav", "no such file"),
        (lambda p: p, ": not a file"),
    ],
)
def test_what_cannot_be_read_right_is_refused_before_anything_is_heard(tmp_path, make, words):
    path = make(tmp_path)
    for use in (read_sound, check_sound, heard):
        with pytest.raises(AudioError, match=words) as caught:
            use(path)
        assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_a_wav_whose_end_is_missing_is_read_up_to_there(tmp_path):
    path = cut(written(tmp_path, "a.wav"))
    assert len(read_sound(path)) == pytest.approx(1.8 * RATE, abs=10)


def test_decoded_sound_may_be_a_little_over_full_scale(tmp_path):
    path = written(tmp_path, "a.wav", 4.0 * TONE, subtype="FLOAT")
    assert np.abs(read_sound(path)).max() == pytest.approx(1.2, abs=0.01)
