# SPDX-License-Identifier: BSD-3-Clause
"""All figures of the robot's motion, in the order of the targets."""

from __future__ import annotations

import os
import time
from dataclasses import replace

from bench.common import resumable
from bench.motion import (
    braking,
    executed,
    insertion,
    inverse,
    paths,
    repeat,
    tension,
    tick,
    triangulate,
)
from bench.motion.gate import feasibility
from rst_control.config import load_motion_config, load_simulation_config
from support.figures import Figure


def measure() -> list[Figure]:
    """Measure everything; BENCH_SHARE=0.05 in the environment makes it twenty times shorter."""
    share = float(os.environ.get("BENCH_SHARE", "1"))

    def count(full: int, minimum: int = 1) -> int:
        return max(minimum, round(full * share))

    motion, simulation = load_motion_config(), load_simulation_config()
    parts = (
        ("paths", lambda: paths.measure(motion, count(1000))),
        ("executed", lambda: executed.measure(motion, simulation, count(12, 2))),
        ("inverse kinematics", lambda: inverse.measure(motion, count(10_000, 100))),
        ("control tick", lambda: tick.measure(motion, simulation, count(20_000, 1000))),
        (
            "feasibility gate",
            lambda: feasibility.measure(motion, simulation, count(10_000), count(40, 2)),
        ),
        ("braking", lambda: braking.measure(motion, simulation, count(60, 5))),
        ("tension", lambda: tension.measure(motion, simulation, count(1000, 25))),
        ("triangulation", lambda: triangulate.measure(motion, count(1000))),
        ("insertion", lambda: insertion.measure(motion, simulation, count(200, 5))),
        ("repeatability", lambda: repeat.measure(motion, simulation, count(100, 3))),
    )
    figures = [resumable.measured(share, "of the whole", 1.0)]
    for name, part in parts:
        begin = time.monotonic()
        figures += part()
        print(f"{name}: {time.monotonic() - begin:.0f} s", flush=True)
    return [replace(figure, value=float(figure.value)) for figure in figures]
