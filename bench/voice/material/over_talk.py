# SPDX-License-Identifier: BSD-3-Clause
"""A word at a level over somebody's talk, and what a network hears in such sound."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray

from voice_assist.audio.mixing import end_of_speech, speech_power
from voice_assist.spotter.overlap import STEP, OverlapNetwork, WindowCutter
from voice_assist.types import RATE, Samples

BEFORE, AFTER = 1.6, 0.64  # [s] of the talk before the word and behind it
LATEST = 0.56  # [s] after the end of a word in which a score of it counts
_PEAK = 0.5  # of full scale
_AT_ONCE = 32  # windows

Scores = NDArray[np.float64]


def over_talk(
    word: Samples,
    talk: Samples | None,
    level: float,
    rng: np.random.Generator,
    around: tuple[float, float] = (BEFORE, AFTER),
) -> tuple[Samples, float]:
    """A word in the middle of talk.

    Args:
        word: Shape (n,).
        talk: Repeated where it is too short; a random part is taken. None: silence.
        level: Power of the word over that of the talk, each while it speaks [dB].
        rng: Chooses the part.
        around: Talk before the word and behind it [s].

    Returns:
        The sound, and when the word ends in it [s].
    """
    before, after = around
    begin = round(before * RATE)
    sound = np.zeros(begin + len(word) + round(after * RATE))
    if talk is not None:
        bed = np.resize(np.roll(talk, -int(rng.integers(len(talk)))), len(sound)).astype(float)
        sound += bed * gain_below(word, talk, level)
    sound[begin:][: len(word)] += word
    return at_peak(sound), before + end_of_speech(word)


def gain_below(word: Samples, other: Samples, level: float) -> float:
    """Factor of another voice that puts a word over it by a level [dB], each while it speaks."""
    ratio = speech_power(word) / max(speech_power(other), 1e-12)
    return float(np.sqrt(ratio / 10 ** (level / 10)))


def at_peak(sound: Samples) -> Samples:
    """The sound with its loudest sample at half of full scale."""
    loudest = max(float(np.abs(sound).max()), 1e-6)
    return np.asarray(sound * (_PEAK / loudest), np.float32)


def scores_of(
    network: OverlapNetwork, sound: Samples, begin: float = 0.0, end: float = np.inf
) -> Scores:
    """Scores of the spotter: the mean of each network pass and the one before.

    Args:
        network: Evaluated as it is shipped.
        sound: Shape (n,), 16 kHz.
        begin: No score before it counts [s].
        end: No score after it counts [s].

    Returns:
        Log-odds [nat], one for each 80 ms from `begin` to `end`.
    """
    windows = list(WindowCutter()(sound))
    first = max(int(np.ceil(begin * RATE / STEP)) - 1, 0)
    last = min(int(min(end, len(sound) / RATE) * RATE / STEP), len(windows))
    chosen = windows[max(first - 1, 0) : last]
    if not chosen:
        return np.zeros(0)
    odds = np.concatenate(
        [_odds(network, chosen[at : at + _AT_ONCE]) for at in range(0, len(chosen), _AT_ONCE)]
    )
    means = np.array([(one + other) / 2 for one, other in pairwise(odds)])
    return means if first else np.concatenate([odds[:1], means])


def _odds(network: OverlapNetwork, windows: Sequence[Samples]) -> Scores:
    with torch.inference_mode():
        found = network(torch.from_numpy(np.stack(windows)))[0]
    return np.asarray(found.numpy(), np.float64).reshape(len(windows))


def alarms(scores: Scores, apart: float = 1.0) -> list[float]:
    """Heights of the highest scores, none of them nearer to a higher one than so many seconds."""
    near = round(apart * RATE / STEP)
    left, found = scores.copy(), []
    while len(left) and np.isfinite(left.max()):
        at = int(left.argmax())
        found.append(float(left[at]))
        left[max(at - near, 0) : at + near + 1] = -np.inf
    return found


def allowed(hours: float, per_hour: float) -> int:
    """Most alarms in so long a time that are no more than so many an hour."""
    return int(per_hour * hours)


def threshold_at(heights: Sequence[float], hours: float, per_hour: float) -> float:
    """Lowest threshold [nat] at which no more than so many alarms an hour are raised."""
    count, higher = allowed(hours, per_hour), sorted(heights, reverse=True)
    return float(np.nextafter(higher[count], np.inf)) if count < len(higher) else -np.inf
