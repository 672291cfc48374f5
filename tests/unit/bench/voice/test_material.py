# SPDX-License-Identifier: BSD-3-Clause
"""Plans and sounds: who says what how often, and how loud the background is."""

from dataclasses import replace

import numpy as np
import pytest

from bench.voice.languages import SaidTwice
from bench.voice.material import held_out_voices, mixing
from bench.voice.material.held_out_voices import SyntheticVoice, spread
from bench.voice.material.mixing import StreamedTrial, stream_of, twice
from bench.voice.material.synthesis import SpokenClip
from voice_assist.types import RATE


def test_every_voice_says_every_text_equally_often():
    cast = [
        SyntheticVoice("pico", "en-US"),
        SyntheticVoice("espeak", "b"),
        SyntheticVoice("mbrola", "mb-us1"),
    ]
    prompts = spread(("tense", "release"), cast, 3, 1)
    count = {}
    for p in prompts:
        count[p.engine, p.voice, p.text] = count.get((p.engine, p.voice, p.text), 0) + 1
        assert 0.85 <= p.rate <= 1.2
    assert set(count.values()) == {3}
    assert len(count) == 6
    assert prompts == spread(("tense", "release"), cast, 3, 1)


def test_voices_that_cannot_speak_are_named_and_left_out(monkeypatch, capsys):
    monkeypatch.setattr(held_out_voices, "_speaks", lambda voice: voice.engine != "pico")
    cast = held_out_voices._sorted_out(
        [SyntheticVoice("pico", "en-US"), SyntheticVoice("espeak", "b")]
    )
    assert cast.present == (SyntheticVoice("espeak", "b"),)
    assert cast.missing == (SyntheticVoice("pico", "en-US"),)
    assert "pico:en-US" in capsys.readouterr().out


@pytest.fixture
def beep(tmp_path, monkeypatch):
    import soundfile

    monkeypatch.setattr(mixing, "ROOT", tmp_path)
    t = np.arange(RATE // 2) / RATE
    for name in "abc":
        soundfile.write(tmp_path / f"{name}.wav", 0.5 * np.sin(2 * np.pi * 440 * t), RATE)
    return [SpokenClip(f"{name}.wav", "stop", "pico", "en-US") for name in "abc"]


def test_twice_means_another_take_of_the_same_voice_after_a_short_gap(beep):
    trials = twice(beep)
    assert [(t.clip.path, t.again.path) for t in trials] == [
        ("a.wav", "b.wav"),
        ("b.wav", "c.wav"),
        ("c.wav", "a.wav"),
    ]
    sound, end, seconds = stream_of(trials[0])
    assert end == pytest.approx(1.0, abs=0.02)
    assert 1.1 <= seconds <= 1.4
    loud = np.abs(sound) > 0.05
    assert not loud[round(1.02 * RATE) : round(1.09 * RATE)].any()
    assert loud[round((seconds + 0.4) * RATE) : round((seconds + 0.45) * RATE)].any()


def test_background_lies_as_far_below_the_speech_as_asked_for(beep):
    quiet, _, _ = stream_of(StreamedTrial(beep[0], 3))
    noisy, _, _ = stream_of(StreamedTrial(beep[0], 3, background="servo", snr=10.0))
    noise = np.asarray(noisy, np.float64) - quiet
    ratio = 0.125 / np.mean(noise**2)
    assert 10 * np.log10(ratio) == pytest.approx(10.0, abs=0.3)


def test_in_another_language_a_motion_is_said_twice_and_a_stop_once(beep):
    (label, once), (again, twice_) = (
        SaidTwice(StreamedTrial(replace(beep[0], text=text), 3), is_moving=True).scene()
        for text in ("stop", "tense")
    )
    assert len(twice_.sound) == 2 * len(once.sound)
    assert again["end"] == pytest.approx(len(once.sound) / RATE + label["end"])
    assert once.is_moving and not (once.keeps_mode or twice_.keeps_mode)
