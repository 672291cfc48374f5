# SPDX-License-Identifier: BSD-3-Clause
"""Damaged sound moves nothing; voices, in noise too, are not taken for it."""

import numpy as np
import pytest

from bench.safety.sound.kinds import byte_swapped, crackle, talk
from support.theatre_sound import speak, theatre_noise
from tests.unit.voice_assist.support import fake_speech
from tests.unit.voice_assist.support.fake_pipeline import commands, make, refusals, run
from voice_assist.audio.corruption import find_corruption, smoothness, spikes
from voice_assist.types import RATE


def rng(seed=3):
    return np.random.default_rng(seed)


def seconds(sound):
    """One second after the other."""
    return [sound[at : at + RATE] for at in range(0, len(sound) - RATE, RATE)]


@pytest.mark.parametrize("command", ["tense", "release", "pull more", "pull less"])
@pytest.mark.parametrize("voice", ["en-us", "en-gb+m3", "en-us+f3"])
@pytest.mark.parametrize("snr", [60, 6, 0])
def test_commands_are_not_damaged(command, voice, snr):
    sound = speak(command, voice, 150).astype(np.float64)
    noise = theatre_noise(len(sound) / RATE + 0.1, 0.1, 3)[: len(sound)].astype(np.float64)
    noise *= np.std(sound) / np.std(noise) * 10 ** (-snr / 20)
    assert find_corruption(np.clip(sound + noise, -1.0, 1.0).astype(np.float32)) == ""


def test_shouted_commands_are_not_damaged():
    loud = np.clip(10.0 * speak("pull more", "en-us", 150), -1.0, 1.0)
    assert find_corruption(loud) == ""


@pytest.mark.parametrize("make_it", [byte_swapped, crackle])
def test_what_broke_on_its_way_is_named(make_it):
    sound = np.clip(make_it(20.0, rng()), -1.0, 1.0).astype(np.float32)
    found = [find_corruption(part) for part in seconds(sound)]
    assert np.mean([words != "" for words in found]) > 0.9
    assert all(words.startswith("damaged sound: ") for words in found if words)


def test_talk_is_not():
    spoken = [part for part in seconds(talk(20.0, rng())) if np.std(part) > 0.01]
    assert len(spoken) > 10
    assert not any(find_corruption(part.astype(np.float32)) for part in spoken)


@pytest.mark.parametrize("length", [0, 1, 2, RATE])
def test_silence_of_any_length_is_not(length):
    silence = np.zeros(length, np.float32)
    assert find_corruption(silence) == "" and smoothness(silence) == 1.0 and spikes(silence) == 0


def heard(words):
    """What came of words in the language of tones, with a spike every 8 ms."""
    sound = np.array(fake_speech.say(words))
    sound[::128] = 1.0
    pipeline, clock = make()
    return run(pipeline, clock, fake_speech.frames(sound))


def test_a_motion_in_damaged_sound_is_refused_and_a_stop_is_not(monkeypatch):
    monkeypatch.setattr(fake_speech.FakeRecognizer, "transcribe", clean(fake_speech.FakeRecognizer))
    events = heard("tense")
    assert commands(events) == []
    assert any(one.rejection.words.startswith("damaged sound: ") for one in refusals(events))
    assert commands(heard("stop")) == ["stop"]


def clean(kind):
    """A recogniser that hears past the spikes."""
    transcribe = kind.transcribe

    def past_them(self, samples, *rest):
        samples = np.array(samples)
        spiky = np.flatnonzero(samples == 1.0)
        samples[spiky] = samples[np.maximum(spiky - 1, 0)]
        return transcribe(self, samples, *rest)

    return past_them
