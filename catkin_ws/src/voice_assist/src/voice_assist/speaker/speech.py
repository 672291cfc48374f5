# SPDX-License-Identifier: BSD-3-Clause
"""The part of a sound in which somebody speaks, by its level alone."""

from __future__ import annotations

import numpy as np

from voice_assist.types import RATE, Samples

BLOCK = 160  # samples that are judged together, 10 ms
BELOW_PEAK_DB = 25.0  # [dB] below the loudest blocks there is no speech
_LOUDEST = 97.0  # [%] of all blocks are quieter than what counts as loudest
_SMOOTH, _WIDEN = 5, 7  # blocks


def spoken(samples: Samples) -> Samples:
    """The sound without its pauses and its offset; empty where there is none at all.

    Args:
        samples: 16 kHz mono. Shape (n,).
    """
    count = len(samples) // BLOCK
    if not count or np.ptp(samples) == 0.0:
        return np.zeros(0, np.float32)
    centred = np.asarray(samples - np.mean(samples), np.float32)
    blocks = centred[: count * BLOCK].reshape(count, BLOCK)
    level = 10.0 * np.log10(np.square(blocks).mean(axis=1) + 1e-10)
    if count >= _SMOOTH:
        level = np.convolve(level, np.full(_SMOOTH, 1.0 / _SMOOTH), "same")
    is_loud = level > np.percentile(level, _LOUDEST) - BELOW_PEAK_DB
    if count >= _WIDEN:
        is_loud = np.convolve(is_loud, np.ones(_WIDEN), "same") > 0.0
    return blocks[is_loud].ravel()


def piece_up(speech: Samples, seconds: float) -> list[Samples]:
    """Equal pieces of a sound, as few as can be, none longer than so many seconds."""
    count = max(1, int(np.ceil(len(speech) / (seconds * RATE))))
    return np.array_split(speech, count)
