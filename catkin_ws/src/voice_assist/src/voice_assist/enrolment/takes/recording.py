# SPDX-License-Identifier: BSD-3-Clause
"""Records one take from any source of sound, and shows how loud it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from voice_assist.audio.source import level_db
from voice_assist.errors import AudioError
from voice_assist.types import RATE, Frame, Samples, frozen_samples

Meter = Callable[[float, float], None]  # level [dB of full scale], share of the take done


def record(frames: Iterator[Frame], seconds: float, meter: Meter) -> Samples:
    """The next stretch of sound.

    Args:
        frames: Of an open source.
        seconds: How much [s].
        meter: Called after each frame.

    Returns:
        Shape (n,), read-only.

    Raises:
        AudioError: The source ended, or sound was lost in between.
    """
    parts: list[Samples] = []
    wanted, expected = round(seconds * RATE), None
    while sum(map(len, parts)) < wanted:
        frame = next(frames, None)
        if frame is None:
            raise AudioError("the sound ended in the middle of a take")
        if expected is not None and frame.first_sample != expected:
            raise AudioError(f"{frame.first_sample - expected} samples of sound were lost")
        expected = frame.next_sample
        parts.append(frame.samples)
        meter(level_db(frame.samples), min(sum(map(len, parts)) / wanted, 1.0))
    return frozen_samples(np.concatenate(parts)[:wanted])
