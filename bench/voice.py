# SPDX-License-Identifier: BSD-3-Clause
"""All figures of the voice, part by part; `make bench ONLY=voice.near` measures one part.

In the environment: THIN=1 takes all clips (3: one in three), HOURS=10 the time of noise, JOBS
the processes, KEEP=1 uses evaluations that are there.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from bench import (
    voice_accuracy,
    voice_calibration,
    voice_denoise,
    voice_idle,
    voice_keywords,
    voice_near,
    voice_nothing,
    voice_speed,
)
from bench.figures import Figure

PARTS: dict[str, Callable[[], list[Figure]]] = {
    "accuracy": voice_accuracy.measure,
    "near": voice_near.measure,
    "calibration": voice_calibration.measure,
    "denoise": voice_denoise.measure,
    "speed": voice_speed.measure,
    "idle": voice_idle.measure,
    "keywords": voice_keywords.measure,
    "nothing": voice_nothing.measure,
}


def measure() -> list[Figure]:
    """Measure all parts."""
    figures: list[Figure] = []
    for name, part in PARTS.items():
        begin = time.monotonic()
        figures += part()
        print(f"{name}: {time.monotonic() - begin:.0f} s", flush=True)
    return figures
