# SPDX-License-Identifier: BSD-3-Clause
"""Item 10: the same commands give the same motion, bit by bit; and how fast time passes."""

from __future__ import annotations

import hashlib
import time
from collections import Counter
from dataclasses import dataclass

import numpy as np

from bench.common.rig import Rig
from rst_control.config import MotionConfig, SimulationConfig
from support.figures import Figure

SESSION = ("tense", "pull more", "pull less", "release")


@dataclass(frozen=True)
class LockStepRun:
    """One session."""

    digest: str  # of all joint positions at 1 kHz, and of the tension after each command
    simulated: float  # [s]
    wall: float  # [s]
    process: float  # [s] of processor time


def measure(config: MotionConfig, simulation: SimulationConfig, runs: int) -> list[Figure]:
    """Run a whole session anew, again and again, in PyBullet.

    Args:
        config: Settings of the controller.
        simulation: Settings of the simulated robot.
        runs: How often.
    """
    done = [run(config, simulation) for _ in range(runs)]
    same = Counter(entry.digest for entry in done).most_common(1)[0][1]
    by_wall = float(np.median([entry.simulated / entry.wall for entry in done]))
    by_process = float(np.median([entry.simulated / entry.process for entry in done]))
    note = (
        f"(median of {runs} sessions of {done[0].simulated:.1f} s: {', '.join(SESSION)}; "
        f"physics and tissue at 1 kHz, control at {config.controller.rate:.0f} Hz, planning)"
    )
    return [
        Figure("same commands, same joints to the bit", same, f"of {runs}", runs, at_most=False),
        Figure(
            "lock-step simulation over real time", by_wall, "times", 10.0, at_most=False, note=note
        ),
        Figure("lock-step simulation over processor time", by_process, "times"),
    ]


def run(config: MotionConfig, simulation: SimulationConfig) -> LockStepRun:
    """Take tissue, pull more, pull less and let go, in a world of its own.

    Raises:
        RuntimeError: A command was not carried out.
    """
    digest = hashlib.sha256()
    with Rig(config, simulation) as rig:

        def observe() -> None:
            digest.update(rig.robot.reading.position.tobytes())

        rig.wake()
        start, wall, process = rig.robot.now, time.perf_counter(), time.process_time()
        for words in SESSION:
            pending = rig.give(words)
            while not pending.ended.done():
                rig.tick(observe)
            if pending.ended.result(0).kind != "succeeded":
                raise RuntimeError(f'"{words}" {pending.ended.result(0)}')
            digest.update(rig.robot.force.tobytes())
        return LockStepRun(
            digest.hexdigest(),
            rig.robot.now - start,
            time.perf_counter() - wall,
            time.process_time() - process,
        )
