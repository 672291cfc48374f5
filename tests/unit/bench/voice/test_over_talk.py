# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
import torch

from bench.voice.material.over_talk import (
    BEFORE,
    alarms,
    allowed,
    over_talk,
    scores_of,
    threshold_at,
)
from voice_assist.spotter.overlap import STEP, WINDOW
from voice_assist.types import RATE


def tone(frequency, seconds, level):
    time = np.arange(int(seconds * RATE)) / RATE
    return (level * np.sin(2 * np.pi * frequency * time)).astype(np.float32)


@pytest.mark.parametrize("level", [12.0, 0.0, -6.0])
def test_the_word_is_as_loud_over_the_talk_as_asked(level):
    word, talk = tone(1000, 0.5, 0.2), tone(100, 1.0, 0.01)
    sound, end = over_talk(word, talk, level, np.random.default_rng(0))
    assert end == pytest.approx(BEFORE + 0.5, abs=0.02)
    alone = sound[: int(BEFORE * RATE)]
    inside = sound[int(BEFORE * RATE) : int(end * RATE)]
    ratio = (np.mean(inside**2) - np.mean(alone**2)) / np.mean(alone**2)
    assert 10 * np.log10(ratio) == pytest.approx(level, abs=0.3)
    assert np.abs(sound).max() == pytest.approx(0.5)


def test_without_talk_there_is_silence_around_the_word():
    sound, end = over_talk(tone(1000, 0.5, 0.2), None, 0.0, np.random.default_rng(0))
    assert not sound[: int(BEFORE * RATE)].any()
    assert end < len(sound) / RATE


class Loudest:
    """Stands for the network: the last sample of a window."""

    def __call__(self, windows):
        assert windows.shape[1] == WINDOW
        return windows[:, -1], torch.zeros(len(windows), 80)


def test_scores_are_means_of_two_and_those_of_the_asked_time():
    sound = np.repeat(np.arange(1, 51, dtype=np.float32), STEP)
    every = scores_of(Loudest(), sound)
    assert every[0] == 1.0
    np.testing.assert_allclose(every[1:], np.arange(1, 50) + 0.5)
    some = scores_of(Loudest(), sound, 10 * STEP / RATE, 20 * STEP / RATE)
    np.testing.assert_allclose(some, np.arange(9, 20) + 0.5)


def test_alarms_are_a_second_apart_and_the_threshold_lets_as_many_through_as_allowed():
    scores = np.full(100, -5.0)
    scores[[10, 12, 50, 80]] = 3.0, 2.0, 1.0, 4.0
    heights = alarms(scores)
    assert heights[:3] == [4.0, 3.0, 1.0]
    threshold = threshold_at(heights, hours=2.0, per_hour=1.0)
    assert sum(height >= threshold for height in heights) == 2


def test_talk_that_is_too_short_for_a_rate_allows_no_alarm():
    assert [allowed(0.645, rate) for rate in (0.5, 1.0, 3.0, 6.0, 12.0)] == [0, 0, 1, 3, 7]
