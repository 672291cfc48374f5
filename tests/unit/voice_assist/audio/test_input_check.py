# SPDX-License-Identifier: BSD-3-Clause
"""Sound in which nobody could be heard is named; speech, however loud, is not."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.theatre_sound import speak
from voice_assist.audio.input_check import SoundWatch
from voice_assist.audio.microphone import Microphone
from voice_assist.audio.source import FRAME, Framer
from voice_assist.audio.wav_file import WavFile
from voice_assist.config import load_voice_config
from voice_assist.types import RATE

PATIENCE = 1.5  # [s]
LONG = round(4.0 * RATE / FRAME) * FRAME  # samples
RNG = np.random.default_rng(7)
QUIET = 1e-3 * RNG.standard_normal(LONG)
DEAFENING = np.clip(10.0 * RNG.standard_normal(LONG), -1.0, 1.0)


def microphone(device="USB headset"):
    config = load_voice_config(audio__microphone__device=device).audio.microphone
    return Microphone(config, None, time.time, lambda seconds: True, lambda words: None)


def watched(sound):
    """The watch after it was shown a sound."""
    watch = SoundWatch(microphone(), PATIENCE)
    for frame in Framer().push(sound, 0.0):
        watch(frame)
    return watch


def objections(sound, source=None):
    """Of each frame."""
    watch = SoundWatch(source or microphone(), PATIENCE)
    return [watch(frame) for frame in Framer().push(sound, 0.0)]


def first(found):
    """When the first objection came [s]."""
    return next(i for i, words in enumerate(found, 1) if words) * FRAME / RATE


@pytest.mark.parametrize("value", [0.0, 0.2, -1.0, 1.0])
def test_one_value_for_ever_is_named_once_it_lasts(value):
    found = objections(np.concatenate([QUIET, np.full(LONG, value)]))
    assert first(found) == pytest.approx(4.0 + PATIENCE, abs=2 * FRAME / RATE)
    (words,) = {words for words in found if words}
    if abs(value) < 1.0:
        assert words.startswith("the microphone gives one value alone for 1.5 s, allowed below")
        assert words.endswith("muted, or dead")
    assert found[-1] == words


def test_deafening_noise_is_named():
    found = objections(np.concatenate([QUIET, DEAFENING]))
    assert first(found) == pytest.approx(4.0 + PATIENCE, abs=2 * FRAME / RATE)
    assert "the microphone is overloaded for 1.5 s, allowed below 1.5 s: too loud" in found[-1]


def test_it_is_over_with_the_first_frame_of_use():
    found = objections(np.concatenate([np.zeros(LONG), QUIET, np.zeros(FRAME * 40)]))
    frames = LONG // FRAME
    assert found[frames - 1] and not any(found[frames:])


def test_a_headset_that_begins_with_zeros_is_not_named():
    assert not any(objections(np.concatenate([np.zeros(round(0.6 * RATE)), QUIET])))


@given(st.integers(1, 40), st.integers(1, 200))
def test_a_room_as_quiet_as_one_bit_is_heard(bits, seed):
    rng = np.random.default_rng(seed)
    sound = rng.integers(-bits, bits + 1, LONG) / 32767
    assert not any(objections(sound))


@pytest.mark.parametrize("gain_db", [0, 20, 30])
def test_shouting_into_it_is_not_taken_for_an_overload(gain_db):
    words = "stop stop hey robot they will bring the second set of instruments and move the table"
    sound = speak(words, "en-us", 160).astype(np.float64)
    sound = sound / np.abs(sound).max() + 1e-4 * RNG.standard_normal(len(sound))
    loud = np.clip(10 ** (gain_db / 20) * sound, -1.0, 1.0)
    assert gain_db == 0 or np.mean(np.abs(loud) >= 0.999) > 0.05
    assert not any(objections(np.tile(loud, 2)))


def test_a_monitor_and_a_recording_may_be_silent_for_ever():
    recording = WavFile("x.wav", time.time, lambda seconds: True, speed=1.0, then_silence=True)
    for source in (microphone("pulse:surgeon.monitor"), recording):
        assert not any(objections(np.zeros(LONG), source))
