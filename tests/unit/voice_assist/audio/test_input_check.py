# SPDX-License-Identifier: BSD-3-Clause
"""Sound in which nobody could be heard is named; speech, however loud, is not."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.theatre_sound import speak
from voice_assist.audio.capture.input_check import SoundWatch
from voice_assist.audio.capture.microphone import Microphone
from voice_assist.audio.source import FRAME, Framer
from voice_assist.audio.wav_file import WavFile
from voice_assist.config import load_voice_config
from voice_assist.types import RATE

PATIENCE = 1.5  # [s]
LONG = round(4.0 * RATE / FRAME) * FRAME  # samples
RNG = np.random.default_rng(7)


def room(level_db, seed=7):
    """Noise that falls with frequency, as air conditioning does, in steps of 16-bit sound."""
    noise = np.random.default_rng(seed).standard_normal(LONG + 100)
    noise = np.convolve(noise, 0.9 ** np.arange(100), "same")[:LONG]
    return np.rint(32767 * 10 ** (level_db / 20) * noise / noise.std()) / 32767


QUIET = room(-60.0)
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
    return list(map(SoundWatch(source or microphone(), PATIENCE), Framer().push(sound, 0.0)))


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


@pytest.mark.parametrize(
    ("noise", "level"),
    [
        (np.where(np.arange(LONG) % FRAME == 7, 1.0, 0.0), "-117 dB"),
        (RNG.integers(-1, 2, LONG), "-92 dB"),  # dither
        (23 * RNG.uniform(-1.0, 1.0, LONG), "-68 dB"),  # of an open input
        (32767 * room(-97.0), "-9"),
    ],
)
def test_a_microphone_muted_by_its_switch_is_named_with_its_level(noise, level):
    found = objections(np.concatenate([QUIET, noise / 32767, QUIET]))
    assert first(found) == pytest.approx(8.0, abs=5 * FRAME / RATE)
    (words,) = {words for words in found if words}
    assert words.startswith(f"the microphone gives {level}")
    assert words.endswith("nothing of a room for 4.0 s, allowed below 4 s: it is muted, or dead")
    assert not found[-1]


@pytest.mark.parametrize("offset", [-330, 40, 100])
def test_an_offset_of_the_card_is_nothing_of_a_room_and_does_not_count_to_the_level(offset):
    noise = np.rint(23 * RNG.uniform(-1.0, 1.0, LONG) + offset) / 32767
    assert objections(np.concatenate([QUIET, noise]))[-1].startswith(
        "the microphone gives -68 dB of full scale and nothing of a room for 4"
    )
    assert not any(objections(room(-85.0) + offset / 32767))


@settings(max_examples=20)
@given(st.floats(-85.0, -20.0), st.integers(1, 200))
def test_a_room_is_heard_however_quiet(level, seed):
    assert not any(objections(np.tile(room(level, seed), 2)))


@pytest.mark.parametrize(
    ("level", "cough"),
    [(-57.0, 0.0), (-40.0, 0.0), (-20.0, 0.0), (-70.0, 0.1)],  # now and then
)
def test_white_noise_as_loud_as_a_room_or_with_a_cough_is_none_of_a_converter(level, cough):
    sound = 10 ** (level / 20) * RNG.standard_normal(4 * LONG)
    sound[:: round(3.5 * RATE)] += cough
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
