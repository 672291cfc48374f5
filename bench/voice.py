# SPDX-License-Identifier: BSD-3-Clause
"""All figures of the voice, part by part; `make bench ONLY=voice.near` measures one part.

In the environment: THIN=1 takes all clips (3: one in three in noise), JOBS the processes, KEEP=1
uses evaluations that are there. The long parts (trials, stop, armed, near, unarmed, nothing, soak)
go on where they were interrupted: see voice_chunks for MODEL, MINUTES and SHARE, voice_kept for
RESULTS and FORCE, and the parts themselves for HOURS.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from bench import (
    voice_accuracy,
    voice_armed,
    voice_calibration,
    voice_denoise,
    voice_idle,
    voice_keywords,
    voice_near,
    voice_nothing,
    voice_soak,
    voice_speed,
    voice_stock,
    voice_stop,
    voice_thresholds,
    voice_trials,
    voice_unarmed,
)
from bench.figures import Figure
from bench.voice_kept import kept

_MEASURES: dict[str, Callable[[], list[Figure]]] = {
    "accuracy": voice_accuracy.measure,
    "trials": voice_trials.measure,
    "stop": voice_stop.measure,
    "near": voice_near.measure,
    "armed": voice_armed.measure,
    "calibration": voice_calibration.measure,
    "thresholds": voice_thresholds.measure,
    "denoise": voice_denoise.measure,
    "speed": voice_speed.measure,
    "idle": voice_idle.measure,
    "keywords": voice_keywords.measure,
    "stock": voice_stock.measure,
    "nothing": voice_nothing.measure,
    "unarmed": voice_unarmed.measure,
    "soak": voice_soak.measure,
}
PARTS = {name: kept(name, part) for name, part in _MEASURES.items()}


def measure() -> list[Figure]:
    """Measure all parts."""
    figures: list[Figure] = []
    for name, part in PARTS.items():
        begin = time.monotonic()
        figures += part()
        print(f"{name}: {time.monotonic() - begin:.0f} s", flush=True)
    return figures
