# SPDX-License-Identifier: BSD-3-Clause
"""Finds sound that was corrupted on its way from the microphone.

Words are found in such sound that nobody said: an hour of talk with its bytes swapped, or through a
loose contact, gave three motions. Both leave marks that no voice and no room has. Of 1,616 commands
in synthetic voices, down to 0 dB, and 653 clips of people, none had a smoothness below 0.31, and of
the commands none more than 3 spikes.
"""

from __future__ import annotations

import numpy as np

from voice_assist.types import RATE, Samples

MIN_SMOOTHNESS = 0.2  # correlation of neighbouring samples; of a voice 0.7 and more, of bytes 0
SPIKE = 0.4  # of full scale that a single sample stands out from both its neighbours
MAX_SPIKES = 8.0  # [1/s] of the sound


def smoothness(sound: Samples) -> float:
    """Correlation of each sample with the next; 1 for silence. Of sound (n,), in [-1, 1]."""
    centred = np.asarray(sound, np.float64) - (np.mean(sound) if len(sound) else 0.0)
    power = float(centred @ centred)
    return float(centred[1:] @ centred[:-1]) / power if power > 0.0 else 1.0


def spikes(sound: Samples) -> int:
    """Single samples that stand out. Of sound (n,), in [-1, 1]."""
    size = np.abs(sound)
    return int(np.count_nonzero(size[1:-1] - np.maximum(size[:-2], size[2:]) >= SPIKE))


def find_corruption(sound: Samples) -> str:
    """Why sound (n,) cannot be relied on; empty: it can."""
    smooth = smoothness(sound)
    if smooth < MIN_SMOOTHNESS:
        return (
            f"damaged sound: neighbouring samples correlate by {smooth:.2f}, "
            f"allowed from {MIN_SMOOTHNESS:g}"
        )
    rate = spikes(sound) / max(len(sound) / RATE, 0.1)
    if rate > MAX_SPIKES:
        return f"damaged sound: {rate:.0f} spikes a second, allowed up to {MAX_SPIKES:g}"
    return ""
