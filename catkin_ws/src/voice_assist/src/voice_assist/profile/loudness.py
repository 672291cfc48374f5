# SPDX-License-Identifier: BSD-3-Clause
"""Where in a take somebody speaks, by level alone, and how loud it is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from voice_assist.audio.mixing import BLOCK, block_powers
from voice_assist.types import RATE, Samples

_SMOOTHED = 5  # blocks; noise alone differs by 10 dB from block to block
_SHORTEST = 4  # blocks in a row that are speech; less is a click
_FLOOR = 15.0  # [per cent] of the blocks are quieter than the level taken for the room's
_ABOVE_FLOOR = 6.0  # [dB] of speech
_BELOW_PEAK, _LEAST_BELOW = 35.0, 10.0  # [dB] of speech, at most; and at least above the threshold
_QUIETEST = 1e-10  # power, -100 dB


def spoken_blocks(samples: Samples) -> NDArray[np.bool_]:
    """Which blocks of 10 ms hold speech. From shape (n,) to (n // 160,)."""
    powers = block_powers(samples)
    if len(powers) < _SMOOTHED:
        return np.zeros(len(powers), np.bool_)
    smooth = np.convolve(powers, np.full(_SMOOTHED, 1.0 / _SMOOTHED), "same")
    peak, floor = float(smooth.max()), float(np.percentile(smooth, _FLOOR))
    over_room = min(floor * 10 ** (_ABOVE_FLOOR / 10), peak * 10 ** (-_LEAST_BELOW / 10))
    threshold = max(over_room, peak * 10 ** (-_BELOW_PEAK / 10), _QUIETEST)
    return _without_clicks(smooth > threshold)


def level_and_snr(samples: Samples) -> tuple[float, float]:
    """Level of the speech [dB of full scale], and over what is around it [dB]."""
    powers, is_speech = block_powers(samples), spoken_blocks(samples)
    if not is_speech.any():
        return -100.0, 0.0
    speech = max(float(powers[is_speech].mean()), _QUIETEST)
    rest = powers[~is_speech]
    quiet = max(float(np.median(rest)) if len(rest) else float(powers.min()), _QUIETEST)
    level = 10.0 * float(np.log10(speech))
    return level, level - 10.0 * float(np.log10(quiet))


def speech_of(samples: Samples, around: float) -> Samples:
    """The part of a take that holds the speech, with some quiet around it.

    Args:
        samples: Shape (n,).
        around: Quiet kept in front and behind [s].

    Returns:
        Shape (m,), m <= n; all of it where nothing is louder than the rest.
    """
    found = np.flatnonzero(spoken_blocks(samples))
    if not len(found):
        return samples
    kept = round(around * RATE)
    start = max(int(found[0]) * BLOCK - kept, 0)
    return samples[start : (int(found[-1]) + 1) * BLOCK + kept]


def _without_clicks(is_speech: NDArray[np.bool_]) -> NDArray[np.bool_]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], is_speech.astype(np.int8), [0]])))
    kept = np.zeros(len(is_speech), np.bool_)
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        kept[start:end] = end - start >= _SHORTEST
    return kept
