# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from tests.unit.voice_assist.support.fake_speech import say
from voice_assist.audio.mixing import add_noise, end_of_speech, speech_power
from voice_assist.profile.loudness import level_and_snr
from voice_assist.types import RATE


def test_the_end_of_speech_is_found_by_level():
    assert end_of_speech(say("stop", before=0.3, after=0.7)) == pytest.approx(0.52, abs=0.011)
    noisy = say("stop", before=0.3, after=0.7)
    noisy = noisy + 0.01 * np.random.default_rng(0).standard_normal(len(noisy))
    assert end_of_speech(noisy.astype(np.float32)) == pytest.approx(0.52, abs=0.03)


def test_a_soft_last_sound_of_a_clip_cut_close_belongs_to_the_speech():
    sound = say("stop stop", before=0.0, after=0.0)
    hiss = 0.02 * np.random.default_rng(0).standard_normal(2400).astype(np.float32)
    assert end_of_speech(np.r_[sound, hiss]) == pytest.approx(len(sound) / RATE + 0.15, abs=0.011)


def restless(level, seed):
    """A second of noise that is so many dB below a word, by block of 10 ms 3 dB more or less."""
    rng = np.random.default_rng(seed)
    gain = 10 ** ((rng.normal(0.0, 3.0, 100) - level) / 20)
    return 0.3 / np.sqrt(2.0) * np.repeat(gain, 160) * rng.standard_normal(RATE)


@pytest.mark.parametrize("level", [25.0, 30.0, 35.0])
@pytest.mark.parametrize("seed", range(5))
def test_a_word_ends_before_the_restless_background_of_its_clip(level, seed):
    word = say("stop", before=0.3, after=0.45)
    assert end_of_speech(word + restless(level, seed)) == pytest.approx(0.52, abs=0.021)


@pytest.mark.parametrize("seed", range(5))
def test_a_burst_after_a_closure_belongs_to_the_word_though_there_is_a_background(seed):
    clip = say("stop", before=0.3, after=0.45) + restless(40.0, seed)
    clip[round(0.6 * RATE) : round(0.63 * RATE)] += 0.1 * say("stop", 0.0, 0.0)[:480]
    assert end_of_speech(clip) == pytest.approx(0.63, abs=0.011)


def test_silence_ends_with_the_clip():
    assert end_of_speech(np.zeros(RATE, np.float32)) == 1.0
    assert end_of_speech(np.zeros(0, np.float32)) == 0.0
    assert speech_power(np.zeros(RATE, np.float32)) == 0.0


@pytest.mark.parametrize("snr_db", [20.0, 0.0])
def test_noise_is_below_the_speech_by_its_ratio(snr_db):
    rng = np.random.default_rng(0)
    speech = say("stop stop stop", before=0.2, after=0.2)
    stream = 0.1 * speech.astype(np.float64)
    noise = rng.standard_normal(4000).astype(np.float32)
    mixed = add_noise(stream, noise, 0.1 * speech, snr_db, rng)
    added = np.square(mixed - stream).mean()
    ratio = 10 * np.log10(speech_power(0.1 * speech) / added)
    assert ratio == pytest.approx(snr_db, abs=0.5)


@pytest.mark.parametrize("offset", [-0.03, 0.003, 0.01])
def test_an_offset_of_the_card_is_no_sound(offset):
    room = 1e-4 * np.random.default_rng(0).standard_normal(RATE)
    clip = np.concatenate([room, 0.1 * say("stop", before=0.0, after=0.0), room])
    shifted = clip + offset
    assert end_of_speech(shifted) == end_of_speech(clip) == pytest.approx(1.22, abs=0.02)
    assert speech_power(shifted) == pytest.approx(speech_power(clip), rel=1e-3)
    (level, snr), (plain_level, plain_snr) = map(level_and_snr, (shifted, clip))
    assert level == pytest.approx(plain_level, abs=0.1)
    assert snr == pytest.approx(plain_snr, abs=0.5) and snr > 40.0
    assert speech_power(np.full(RATE, offset)) == 0.0


def test_silent_noise_changes_nothing():
    rng = np.random.default_rng(0)
    stream = 0.1 * say("stop").astype(np.float64)
    np.testing.assert_array_equal(
        add_noise(stream, np.zeros(100, np.float32), say("stop"), 0.0, rng), stream
    )
