# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from tests.unit.voice_assist.support.fake_speech import frames, say
from voice_assist.audio.denoise import Denoiser, HighPass, SpectralGate
from voice_assist.audio.source import level_db
from voice_assist.config import load_voice_config
from voice_assist.types import RATE


def run(stage, sound):
    return np.concatenate([stage(f.samples) for f in frames(np.asarray(sound, np.float32))])


def sine(frequency, seconds=1.0, amplitude=0.2):
    return amplitude * np.sin(2 * np.pi * frequency * np.arange(round(seconds * RATE)) / RATE)


def hiss(seconds, amplitude=0.01):
    return amplitude * np.random.default_rng(3).standard_normal(round(seconds * RATE))


def test_rumble_is_removed_and_speech_is_left():
    assert level_db(run(HighPass(80.0), sine(20.0))[8000:]) < level_db(sine(20.0)) - 20
    assert level_db(run(HighPass(80.0), sine(500.0))[8000:]) > level_db(sine(500.0)) - 0.5


@pytest.mark.parametrize("cutoff", [20.0, 80.0, 300.0])
def test_the_high_pass_is_butterworths_in_blocks_of_any_length(cutoff):
    sound = hiss(0.3).astype(np.float32)
    stage = HighPass(cutoff)
    heard = np.concatenate([stage(part) for part in np.split(sound, [1, 3, 259, 300, 2000])])
    wanted = sosfilt(butter(2, cutoff, "highpass", fs=RATE, output="sos"), sound)
    np.testing.assert_allclose(heard, wanted, atol=1e-8)


def test_a_filter_at_zero_lets_everything_pass():
    sound = np.asarray(sine(20.0), np.float32)
    whole = sound[: len(sound) // 512 * 512]
    np.testing.assert_allclose(run(HighPass(0.0), sound), whole, atol=2e-5)


def test_a_gate_that_reduces_nothing_only_delays():
    sound = np.asarray(hiss(1.024, 0.1), np.float32)
    cleaned = run(SpectralGate(0.0, 6.0, 6.0), sound)
    delay = SpectralGate.delay
    np.testing.assert_allclose(cleaned[delay:], sound[:-delay], atol=5e-5)


VARIES = 1.0 + 0.3 * np.sin(np.arange(6 * RATE) / RATE * 2.0)


@pytest.mark.parametrize("noise", [hiss(4.0), hiss(6.0) * VARIES])
def test_noise_is_turned_down_steady_or_varying(noise):
    level = level_db(noise.astype(np.float32))
    assert level_db(run(SpectralGate(18.0, 6.0, 6.0), noise)[RATE:]) < level - 9


def test_noise_is_turned_down_by_no_more_than_was_asked_for():
    noise = hiss(4.0)
    cleaned = run(SpectralGate(12.0, 6.0, 6.0), noise)
    assert level_db(cleaned[RATE:]) > level_db(noise.astype(np.float32)) - 12.5


def test_words_in_noise_keep_their_level():
    noise = hiss(3.0, 0.005)
    word = np.zeros(len(noise))
    word[RATE : RATE + 8000] = sine(700.0, 0.5)
    cleaned = run(SpectralGate(18.0, 6.0, 6.0), noise + word)
    inside = slice(RATE + 1000, RATE + 7000)
    assert level_db(cleaned[inside]) > level_db((noise + word)[inside].astype(np.float32)) - 1.5


@pytest.mark.parametrize("loud", [0.03, 0.1, 0.3])
def test_a_word_said_right_after_loud_noise_keeps_its_level(loud):
    noise = np.concatenate([hiss(4.0, loud), hiss(1.5, 1e-4)])
    word = np.zeros(len(noise))
    first = round(4.3 * RATE)
    word[first : first + 8000] = sine(700.0, 0.5, 0.05)
    cleaned = run(SpectralGate(18.0, 6.0, 6.0), noise + word)
    inside = slice(first + 1000, first + 7000)
    assert level_db(cleaned[inside]) > level_db(word[inside].astype(np.float32)) - 1.5


def test_silence_stays_silence_in_whole_hops():
    cleaned = run(SpectralGate(18.0, 6.0, 6.0), np.zeros(RATE))
    assert np.isfinite(cleaned).all() and not cleaned.any()
    with pytest.raises(ValueError, match="multiples of 256"):
        SpectralGate(18.0, 6.0, 6.0)(np.zeros(100, np.float32))


def test_switched_off_nothing_is_touched():
    denoise = Denoiser(load_voice_config(audio__denoise__mode="off").audio.denoise)
    samples = frames(say("tense"))[20].samples
    assert denoise(samples) is samples


def test_a_reset_forgets_the_stream():
    denoise = Denoiser(load_voice_config().audio.denoise)
    sound = np.asarray(hiss(0.512), np.float32)
    first = run(denoise, sound)
    denoise.reset()
    np.testing.assert_array_equal(run(denoise, sound), first)
