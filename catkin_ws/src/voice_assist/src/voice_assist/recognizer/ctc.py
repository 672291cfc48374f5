# SPDX-License-Identifier: BSD-3-Clause
"""Reading the CTC head: greedy text and forced alignment."""

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
    score = np.full(len(labels), -np.inf)
    score[:2] = emitted[0, :2]
    came = np.zeros(emitted.shape, np.int8)  # states advanced on entering
    can_skip = _skippable(labels)
    for time in range(1, len(emitted)):
        options = np.full((3, len(labels)), -np.inf)
        options[0], options[1, 1:] = score, score[:-1]
        options[2, can_skip] = score[:-2][can_skip[2:]]
        came[time] = options.argmax(axis=0)
        score = options.max(axis=0) + emitted[time]
    state = len(labels) - 1 - int(score[-2] > score[-1])
    return float(score[state]), _trace(emitted, came, state)


def _skippable(labels: Ints) -> NDArray[np.bool_]:
    """States that may be entered over the blank before them."""
    skips = np.zeros(len(labels), bool)
    skips[2:] = (labels[2:] != BLANK) & (labels[2:] != labels[:-2])
    return skips


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
