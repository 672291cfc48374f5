# SPDX-License-Identifier: BSD-3-Clause
"""All figures of the voice, part by part; `make bench ONLY=voice.near` measures one part.

In the environment: THIN=1 takes all clips (3: one in three in noise), JOBS the processes. The long
parts (trials, stop, armed, near, foreign, ask, unarmed, nothing) go on where they were interrupted:
see bench/common/resumable.py for MINUTES, SHARE, RESULTS and FORCE, hearing/pieces.py and sizes.py
for MODEL,
and the parts themselves for HOURS and SOAK.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from bench.voice import ask, calibration, idle, overlap, overlap_network, sizes, stop, trials
from bench.voice.no_commands import armed, false_alarms, foreign, near_misses, unarmed
from bench.voice.soak import suite as soak
from support.figures import Figure

PARTS: dict[str, Callable[[], list[Figure]]] = {
    "trials": trials.measure,
    "stop": stop.measure,
    "overlap": overlap.measure,
    "near": near_misses.measure,
    "foreign": foreign.measure,
    "ask": ask.measure,
    "overlap_network": overlap_network.measure,
    "sizes": sizes.measure,
    "armed": armed.measure,
    "calibration": calibration.measure,
    "idle": idle.measure,
    "nothing": false_alarms.measure,
    "unarmed": unarmed.measure,
    "soak": soak.measure,
}


def measure() -> list[Figure]:
    """Measure all parts."""
    figures: list[Figure] = []
    for name, part in PARTS.items():
        begin = time.monotonic()
        figures += part()
        print(f"{name}: {time.monotonic() - begin:.0f} s", flush=True)
    return figures
