# SPDX-License-Identifier: BSD-3-Clause
"""Several channels to one: their mean, without those that are silent or of opposite sign.

A balanced microphone on a stereo socket gives its sound twice, with opposite signs, and their mean
is silence. Such a channel is turned over before the mean is taken. Of an interface with many
sockets and one microphone, the channels without signal are left out: they would only weaken it.
Channels that all have a signal, of any correlation but a clearly negative one, are averaged.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from voice_assist.types import FULL_SCALE, RATE, Samples

Weights = NDArray[np.float64]  # (channels,), whose sizes add up to 1

_MEMORY = 0.2  # [s] in which a stream's channels count less by a factor of e
_SILENT, _BACK = 0.01, 0.04  # power beside the strongest channel: below it left out, from it back
_TURNED, _STRAIGHT = -0.6, 0.3  # correlation with the strongest: below it turned over, from it back
_NO_POWER = 1e-30


def plain(channels: int) -> Weights:
    """Those of a mean."""
    return np.full(channels, 1.0 / channels)


def products(block: NDArray[np.generic]) -> NDArray[np.float64]:
    """Sums of products of all pairs of channels, (channels, channels). Of shape (n, channels)."""
    values = np.asarray(block, np.float64)
    centred = values - values.mean(axis=0) if len(values) else values
    return np.asarray(centred.T @ centred)


def weights(sums: NDArray[np.float64], before: Weights) -> Weights:
    """What each channel counts in the mean.

    Args:
        sums: As `products` gives them. Shape (channels, channels).
        before: The present weights; a channel keeps its part while it is not clearly another.
    """
    power = np.diag(sums)
    strongest = int(power.argmax())
    if power[strongest] <= _NO_POWER:
        return before
    alike = sums[strongest] / np.sqrt(np.maximum(power * power[strongest], _NO_POWER))
    was_turned = before * before[strongest] < 0.0
    has_signal = power >= power[strongest] * np.where(before == 0.0, _BACK, _SILENT)
    signs = np.where(alike < np.where(was_turned, _STRAIGHT, _TURNED), -1.0, 1.0)
    found = np.where(has_signal, signs, 0.0) / np.count_nonzero(has_signal)
    return found if found @ before >= 0.0 else -found  # the sum keeps its sign


def mix(block: NDArray[np.generic], counts: Weights) -> Samples:
    """One channel, float32 in [-1, 1]. From int16 or float, (n,) or (n, channels), to (n,)."""
    scale = float(FULL_SCALE) if block.dtype == np.int16 else 1.0
    values = np.asarray(block, np.float32) / np.float32(scale)
    if values.ndim == 1:
        return values
    if np.ptp(counts) == 0.0:
        return np.asarray(values.mean(axis=1), np.float32)
    return values @ np.asarray(counts, np.float32)


def remark(counts: Weights) -> str:
    """What a person should know of it; empty: nothing."""
    first = counts[np.flatnonzero(counts)[0]]
    turned = [str(number) for number, count in enumerate(counts, 1) if count * first < 0.0]
    if not turned:
        return ""
    return (
        f"channel {', '.join(turned)} of {len(counts)} has the opposite sign of the first, as of a "
        "balanced microphone on a stereo socket: it is turned over"
    )


class StreamMixer:
    """Mixes a stream block by block, by what was in it recently.

    Args:
        rate: Of the stream [Hz].
    """

    def __init__(self, rate: int = RATE) -> None:
        self._rate = rate
        self._sums = np.zeros((0, 0))
        self._counts = plain(1)

    @property
    def remark(self) -> str:
        """What a person should know of the channels; empty: nothing."""
        return remark(self._counts)

    def __call__(self, block: NDArray[np.generic]) -> Samples:
        """Mix one block. From int16 or float, (n,) or (n, channels), to float32 (n,)."""
        if block.ndim == 2 and block.shape[1] > 1:
            self._follow(block)
        return mix(block, self._counts)

    def _follow(self, block: NDArray[np.generic]) -> None:
        channels = block.shape[1]
        if len(self._counts) != channels:
            self._sums, self._counts = np.zeros((channels, channels)), plain(channels)
        kept = np.exp(-len(block) / (self._rate * _MEMORY))
        self._sums = kept * self._sums + products(block)
        self._counts = weights(self._sums, self._counts)
