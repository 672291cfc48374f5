# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from paper.judging.truth import SoundBlock, find
from voice_assist.audio.mixing import end_of_speech
from voice_assist.types import RATE

BLOCK = 512
T0 = 1_700_000_000.0  # [s]


@pytest.fixture
def phrase():
    """Half a second of voice-like sound whose last fifth fades to nothing."""
    rng = np.random.default_rng(1)
    n = RATE // 2
    sound = 0.1 * rng.standard_normal(n) * np.sin(np.pi * np.arange(n) / n * 7) ** 2
    sound[-RATE // 10 :] *= 1e-3
    return sound.astype(np.float32)


def captured(phrase, at, seconds=3.0, noise=0.002, jitter=0.0, cut=0.0):
    """Blocks as the voice node publishes them, with the phrase at a time [s] after T0."""
    rng = np.random.default_rng(2)
    sound = noise * rng.standard_normal(int(seconds * RATE))
    first = round(at * RATE)
    if cut:  # the player paused in the middle
        half = len(phrase) // 2
        pieces = [phrase[:half], np.zeros(int(cut * RATE)), phrase[half:]]
        phrase = np.concatenate(pieces)
    sound[first : first + len(phrase)] += phrase
    pcm = np.round(sound * 32767).astype(np.int16)
    return [
        SoundBlock(T0 + i / RATE + jitter * rng.uniform(-1, 1), 1000 + i, pcm[i : i + BLOCK])
        for i in range(0, len(pcm), BLOCK)
    ]


def test_the_end_of_a_phrase_is_its_last_audible_moment(phrase):
    assert end_of_speech(phrase) == pytest.approx(0.4, abs=0.011)


def test_a_phrase_ends_where_the_other_benches_have_its_end(phrase):
    loudest = np.sqrt(np.square(phrase).reshape(-1, 160).mean(axis=1).max())
    soft = 10 ** (-33 / 20) * loudest * np.resize([1.0, -1.0], RATE // 10)
    said = np.concatenate([phrase[: -RATE // 10], soft, np.zeros(RATE // 10)]).astype(np.float32)
    found = find(said, captured(said, 1.0), T0 + 0.9, T0 + 1.6)
    assert found.end - T0 == pytest.approx(1.5, abs=0.011)
    assert end_of_speech(said) == pytest.approx(0.5)


def test_the_end_does_not_depend_on_silence_behind_it(phrase):
    longer = np.concatenate([phrase, np.zeros(RATE, np.float32)])
    assert end_of_speech(longer) == end_of_speech(phrase)


@pytest.mark.parametrize("at", [0.3, 0.8123, 1.9])
def test_a_phrase_is_found_where_it_sounded(phrase, at):
    found = find(phrase, captured(phrase, at), T0 + at - 0.1, T0 + at + 0.6)
    assert found.begin - T0 == pytest.approx(at, abs=2 / RATE)
    assert found.end - found.begin == pytest.approx(end_of_speech(phrase))
    assert found.likeness > 0.95


def test_uneven_stamps_are_evened_out(phrase):
    found = find(phrase, captured(phrase, 1.0, jitter=0.005), T0 + 0.9, T0 + 1.6)
    assert found.begin - T0 == pytest.approx(1.0, abs=0.002)


def test_louder_or_softer_makes_no_difference(phrase):
    found = find(phrase, captured(0.5 * phrase, 1.0), T0 + 0.9, T0 + 1.6)
    assert found.begin - T0 == pytest.approx(1.0, abs=2 / RATE)


def test_a_phrase_that_was_torn_apart_is_not_found(phrase):
    assert find(phrase, captured(phrase, 1.0, cut=0.05), T0 + 0.9, T0 + 1.6) is None


def test_a_phrase_that_never_sounded_is_not_found(phrase):
    assert find(phrase, captured(0.0 * phrase, 1.0), T0 + 0.9, T0 + 1.6) is None


def test_a_phrase_elsewhere_in_the_session_is_not_taken_for_this_one(phrase):
    blocks = captured(phrase, 0.5, seconds=6.0)
    assert find(phrase, blocks, T0 + 4.0, T0 + 4.6) is None


def test_lost_sound_leaves_the_times_right(phrase):
    blocks = captured(phrase, 1.5)
    del blocks[5:8]  # long before the phrase
    found = find(phrase, blocks, T0 + 0.4, T0 + 2.1)
    assert found.begin - T0 == pytest.approx(1.5, abs=2 / RATE)
