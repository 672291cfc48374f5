# SPDX-License-Identifier: BSD-3-Clause
"""Reading the CTC head: greedy text, forced alignment, likelihood of a text."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from voice_assist.recognizer.vocabulary import BLANK, decode

Floats = NDArray[np.float32]
Ints = NDArray[np.int64]


def greedy_text(logprobs: Floats) -> str:
    """Best path, repeats and blanks removed; logprobs (time, BLANK + 1)."""
    path = logprobs.argmax(axis=1)
    is_new = np.append(True, path[1:] != path[:-1])
    return decode(path[is_new & (path != BLANK)].tolist())


def best_alignment(logprobs: Floats, text: Ints) -> tuple[float, Ints]:
    """Viterbi alignment (Graves et al. 2006).

    Args:
        logprobs: Shape (time, BLANK + 1).
        text: Character ids. Shape (n,), n >= 1.

    Returns:
        Log-probability of the best path (-inf where the text does not fit) and
        the frame in which each character is strongest, shape (n,).
    """
    labels = np.full(2 * len(text) + 1, BLANK)
    labels[1::2] = text
    emitted = logprobs[:, labels]  # (time, states)
    can_skip = _skippable(labels)
    score = np.full(len(labels), -np.inf)
    score[:2] = emitted[0, :2]
    came = np.zeros(emitted.shape, np.int8)  # states advanced on entering
    for time in range(1, len(emitted)):
        options = np.stack([score, _shift(score, 1), _shift(score, 2)])
        options[2, ~can_skip] = -np.inf
        came[time] = options.argmax(axis=0)
        score = options.max(axis=0) + emitted[time]
    state = len(labels) - 1 - int(score[-2] > score[-1])
    return float(score[state]), _trace(emitted, came, state)


def log_likelihood(logprobs: Floats, text: Ints) -> float:
    """Log-probability of a text over all alignments (Graves et al. 2006).

    Args:
        logprobs: Shape (time, BLANK + 1).
        text: Character ids. Shape (n,); n = 0 is silence.
    """
    labels = np.full(2 * len(text) + 1, BLANK)
    labels[1::2] = text
    emitted = logprobs[:, labels].astype(np.float64)
    can_skip = _skippable(labels)
    score = np.full(len(labels), -np.inf)
    score[:2] = emitted[0, :2]
    for now in emitted[1:]:
        skipped = np.where(can_skip, _shift(score, 2), -np.inf)
        score = np.logaddexp(np.logaddexp(score, _shift(score, 1)), skipped) + now
    return float(np.logaddexp.reduce(score[-2:]))


def _skippable(labels: Ints) -> NDArray[np.bool_]:
    """States that may be entered over the blank before them."""
    skips = np.zeros(len(labels), bool)
    skips[2:] = (labels[2:] != BLANK) & (labels[2:] != labels[:-2])
    return skips


def _shift(score: NDArray[np.float64], by: int) -> NDArray[np.float64]:
    shifted = np.full_like(score, -np.inf)
    shifted[by:] = score[:-by]
    return shifted


def _trace(emitted: Floats, came: NDArray[np.int8], state: int) -> Ints:
    """Strongest frame of each character on the best path ending in a state."""
    characters = emitted.shape[1] // 2
    frames = np.zeros(characters, np.int64)
    strongest = np.full(characters, -np.inf)
    for time in range(len(emitted) - 1, -1, -1):
        if state % 2 and emitted[time, state] > strongest[state // 2]:
            strongest[state // 2] = emitted[time, state]
            frames[state // 2] = time
        state -= int(came[time, state])
    return frames
