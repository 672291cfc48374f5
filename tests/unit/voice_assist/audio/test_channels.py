# SPDX-License-Identifier: BSD-3-Clause
"""Channels that cancel each other, or of which few have a signal, are heard as one."""

import numpy as np
import pytest
import soundfile

from support.theatre_sound import speak
from voice_assist.audio.channels import StreamMixer, mix, plain
from voice_assist.audio.resample import Resampler
from voice_assist.audio.sound_file import read_sound
from voice_assist.audio.source import level_db
from voice_assist.types import RATE

RNG = np.random.default_rng(3)
SPEECH = speak("pull more and then release", "en-us", 150).astype(np.float64)
PAUSE = np.zeros(RATE)
SAID = np.concatenate([PAUSE, SPEECH, PAUSE, SPEECH])


def noise():
    return 1e-4 * RNG.standard_normal(len(SAID))


def streamed(channels):
    """What comes of a stream of blocks of 32 ms, and the mixer."""
    mixer = StreamMixer()
    sound = np.stack(channels, axis=1)
    blocks = [mixer(sound[at : at + 512]) for at in range(0, len(sound), 512)]
    return np.concatenate(blocks), mixer


def read(tmp_path, channels):
    soundfile.write(tmp_path / "sound.wav", np.stack(channels, axis=1), RATE, subtype="FLOAT")
    return read_sound(tmp_path / "sound.wav")


def alike(one, other):
    return abs(float(np.corrcoef(one, other)[0, 1]))


def test_opposite_signs_are_heard_at_full_level_from_the_first_word_on(tmp_path, caplog):
    channels = [SAID + noise(), -SAID + noise()]
    heard, mixer = streamed(channels)
    for sound in (heard, read(tmp_path, channels)):
        assert alike(sound, SAID) > 0.999
        assert level_db(sound) == pytest.approx(level_db(SAID.astype(np.float32)), abs=0.1)
    words = "channel 2 of 2 has the opposite sign of the first"
    assert words in mixer.remark and words in caplog.text


def test_it_stays_so_through_a_pause_and_the_sound_keeps_its_sign():
    heard, _ = streamed([SAID + noise(), -SAID + noise()])
    words = np.abs(SAID) > 0.05
    assert abs(np.mean(np.sign(heard[words]) * np.sign(SAID[words]))) > 0.99


@pytest.mark.parametrize("live", [0, 1, 5])
def test_one_microphone_on_an_interface_of_many_sockets_keeps_its_level(live, tmp_path):
    channels = [noise() for _ in range(6)]
    channels[live] = channels[live] + SAID
    heard, mixer = streamed(channels)
    words = np.abs(SAID) > 0.01
    assert level_db(heard[words]) == pytest.approx(level_db(SAID[words]), abs=0.2)
    assert level_db(read(tmp_path, channels)[words]) == pytest.approx(
        level_db(SAID[words]), abs=0.2
    )
    assert mixer.remark == ""


@pytest.mark.parametrize(
    "other", [SAID, 0.5 * SAID, np.roll(SAID, 40), 0.3 * RNG.random(len(SAID))]
)
def test_what_does_not_cancel_is_their_mean_as_ever(other, tmp_path):
    channels = [SAID, other]
    mean = np.stack(channels, axis=1).astype(np.float32).mean(axis=1)
    np.testing.assert_array_equal(read(tmp_path, channels), mean)


def test_hum_of_opposite_sign_does_not_cost_a_word_of_the_same():
    hum = 0.003 * np.sin(2 * np.pi * 50 * np.arange(len(SAID)) / RATE)
    heard, _ = streamed([SAID + hum, SAID - hum])
    assert alike(heard, SAID) > 0.99


def test_a_loud_crackle_of_opposite_sign_is_soon_forgotten():
    crackle = np.zeros(len(SAID))
    crackle[: RATE // 2] = RNG.uniform(-1.0, 1.0, RATE // 2)
    heard, _ = streamed([SAID + crackle, SAID - crackle])
    assert alike(heard[3 * RATE // 2 :], SAID[3 * RATE // 2 :]) > 0.95


def test_silence_is_silence_and_a_block_of_one_channel_stays_as_it_is():
    heard, _ = streamed([np.zeros(RATE), np.zeros(RATE)])
    assert not heard.any()
    block = RNG.uniform(-1.0, 1.0, 512).astype(np.float32)
    np.testing.assert_array_equal(StreamMixer()(block), block)
    np.testing.assert_array_equal(mix(block[:, None], plain(1)), block)


def test_a_device_at_its_own_rate_is_mixed_too():
    both = np.stack([SAID, -SAID], axis=1)
    resample = Resampler(48_000)
    heard = np.concatenate([resample(np.repeat(both, 3, axis=0)), resample(both[:0], is_last=True)])
    assert alike(heard[: len(SAID)], SAID[: len(heard)]) > 0.99 and resample.remark
