# SPDX-License-Identifier: BSD-3-Clause
"""Item 10: the same commands give the same motion, bit by bit; and how fast time passes."""

from __future__ import annotations

import hashlib
import time
from collections import Counter

from bench.figures import Figure
from bench.motion.rig import Rig
from rst_control.config import MotionConfig, SimulationConfig

DURATION = 3.0  # [s] of simulated time in each run


def measure(config: MotionConfig, simulation: SimulationConfig, runs: int) -> list[Figure]:
    """Run "tense" anew, again and again, in PyBullet.

    Args:
        config: Settings of the controller.
        simulation: Settings of the simulated robot.
        runs: How often.
    """
    hashes, passed = Counter[str](), 0.0
    for _ in range(runs):
        with Rig(config, simulation) as rig:
            rig.wake()
            rig.give("tense")
            digest = hashlib.sha256()

            def look(rig: Rig = rig, digest: hashlib._Hash = digest) -> None:
                digest.update(rig.robot.reading.position.tobytes())

            begin, start = time.perf_counter(), rig.robot.now
            while rig.robot.now < start + DURATION:
                rig.tick(look)
            passed += time.perf_counter() - begin
            hashes[digest.hexdigest()] += 1
    same = hashes.most_common(1)[0][1]
    factor = runs * DURATION / passed
    return [
        Figure("same commands, same joints to the bit", same, f"of {runs}", runs, at_most=False),
        Figure("lock-step simulation over real time", factor, "times", 10.0, at_most=False),
    ]
