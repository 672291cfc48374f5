# SPDX-License-Identifier: BSD-3-Clause
"""Where the speech of a clip ends, how loud it is, and noise at a level below it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from voice_assist.types import RATE, Samples

BLOCK = 160  # samples, 10 ms
_BELOW_PEAK_DB = 35.0  # of a block that still counts as speech, against the loudest
_ABOVE_NOISE = 10.0  # power of a block that counts as speech, over that of the noise
_BACKGROUND = 1.0 / 3.0  # of a clip's blocks are near the quietest, where it has a background
_QUIETEST = 1e-10  # power


def block_powers(samples: Samples) -> NDArray[np.float64]:
    """Mean power of each 10 ms without the offset of them all. From shape (n,) to (n // 160,)."""
    count = len(samples) // BLOCK
    blocks = np.asarray(samples[: count * BLOCK], np.float64).reshape(count, BLOCK)
    offset = blocks.mean() if count else 0.0
    return np.asarray(np.square(blocks - offset).mean(axis=1))


def speech_blocks(samples: Samples) -> NDArray[np.bool_]:
    """Which blocks of 10 ms hold speech, by their level alone.

    A block does that is at most 35 dB below the loudest and at least 10 dB over the quietest. No
    detector is asked, so that none can flatter itself. A background that varies by more than that
    counts, too: `end_of_speech` leaves it out.
    """
    powers = block_powers(samples)
    return _loud(powers, float(powers.min(initial=np.inf)))


def _loud(powers: NDArray[np.float64], noise: float) -> NDArray[np.bool_]:
    """Which blocks are near the loudest and over a power of noise."""
    peak = float(powers.max(initial=0.0))
    above = min(noise * _ABOVE_NOISE, peak / _ABOVE_NOISE)
    return np.asarray(powers >= max(peak * 10 ** (-_BELOW_PEAK_DB / 10), above, _QUIETEST))


def _background(powers: NDArray[np.float64]) -> float:
    """Power of a clip's background; of its quietest block where it is cut close to the speech."""
    quietest = float(powers.min(initial=np.inf))
    near = powers[powers <= quietest * _ABOVE_NOISE]
    return float(np.median(near)) if len(near) > _BACKGROUND * len(powers) else quietest


def trimmed(samples: Samples) -> Samples:
    """From the first speech to the last. From shape (n,) to (m,); all of it without speech."""
    found = np.flatnonzero(speech_blocks(samples))
    return samples[found[0] * BLOCK : (found[-1] + 1) * BLOCK] if len(found) else samples


def end_of_speech(samples: Samples) -> float:
    """Time at which the speech of a clip ends [s]; its length where it holds none.

    That is the last block of 10 ms that is at most 35 dB below the loudest, and at least 10 dB over
    the background. The background is the median of the blocks within 10 dB of the quietest, where
    these are a third of the clip. A clip without that many has none: the quietest block counts.
    """
    powers = block_powers(samples)
    found = np.flatnonzero(_loud(powers, _background(powers)))
    return float(found[-1] + 1) * BLOCK / RATE if len(found) else len(samples) / RATE


def speech_power(samples: Samples) -> float:
    """Mean power while there is speech; 0 for silence."""
    is_speech = speech_blocks(samples)
    return float(block_powers(samples)[is_speech].mean()) if is_speech.any() else 0.0


def add_noise(
    stream: NDArray[np.float64],
    noise: Samples,
    speech: Samples,
    snr_db: float,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Add noise to all of a stream.

    Args:
        stream: Shape (n,).
        noise: Any length; a random part is taken, repeated where it is too short.
        speech: The speech inside the stream, whose level counts.
        snr_db: Power of the speech, while there is some, over that of the noise [dB].
        rng: Chooses the part.

    Returns:
        Shape (n,), clipped to [-1, 1].
    """
    start = int(rng.integers(len(noise)))
    part = np.resize(np.roll(noise, -start), len(stream)).astype(np.float64)
    power = float(np.square(part).mean())
    wanted = speech_power(speech) / 10 ** (snr_db / 10)
    gain = np.sqrt(wanted / power) if power > 0.0 else 0.0
    return np.clip(stream + gain * part, -1.0, 1.0)
