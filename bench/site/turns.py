# SPDX-License-Identifier: BSD-3-Clause
"""Plans from the same place with every endless joint written in each of its turns.

A plan is compared with the shortest one over all turns of its start: no joint may move more than
pi further. The elbow may move as far as rcm.yaml allows. Refusals are counted by their reason.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bench.common import resumable
from bench.motion.inverse import reachable
from rst_control.config import load_motion_config
from rst_control.errors import Infeasible
from rst_control.kinematics.joint_limits import TURN
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.insertion import Insertion
from rst_control.planning.planner import Planner
from rst_control.trajectory.path import Path
from rst_control.types import Vector
from support.figures import Figure

Array = NDArray[np.float64]
FULL: Final = 1000  # starts
STARTS: Final = int(os.environ.get("BENCH_TURNS", str(FULL)))


@dataclass(frozen=True)
class Way:
    """How far one plan moves the arm."""

    joints: Vector  # (9,), [rad] of each joint along the plan
    excess: float  # [rad] of a joint beyond the shortest plan over all turns
    elbow: float  # [m]
    elbow_allowed: float  # [m]


class Turns:
    """Draws starts and plans from each of their turns.

    Args:
        planner: For this robot and scene.
    """

    def __init__(self, planner: Planner) -> None:
        self._planner, self._insertion = planner, Insertion(planner)
        self.refusals: Counter[str] = Counter()

    def starts(self, count: int, seed: int) -> list[Vector]:
        """Joints (9,) [rad] with the tip in the workspace and the shaft in the trocar."""
        planner, found = self._planner, list[Vector]()
        home = np.array(planner.config.scene.home)
        poses = reachable(planner, 2 * count)
        np.random.default_rng(seed).shuffle(poses)
        for pose in poses:
            result = planner.solver.search(pose, planner.trocar, home)
            if result.is_solved and len(found) < count:
                found.append(result.q)
        return found

    def reach(self, q: Vector) -> Sequence[Path]:
        """Ways to the tissue."""
        return self._planner.reach(q)

    def insert(self, q: Vector) -> Sequence[Path]:
        """Ways from outside the patient to the working pose."""
        return [leg.path for leg in self._insertion.insert(q)]

    def from_each_turn(self, q: Vector, plan: Callable[[Vector], Sequence[Path]]) -> list[Way]:
        """The plans from all turns of q (9,) that the limits leave; refused ones are left out."""
        measured = []
        for start in self._turned(q):
            try:
                measured.append(self._measure(plan(start)))
            except Infeasible as error:
                self.refusals[type(error).__name__] += 1
        if not measured:
            return []
        shortest = min((joints for joints, *_ in measured), key=lambda joints: float(joints.max()))
        return [
            Way(joints, float((joints - shortest).max()), elbow, allowed)
            for joints, elbow, allowed in measured
        ]

    def _turned(self, q: Vector) -> list[Vector]:
        limits, places = self._planner.limits, []
        for j in range(9):
            turns = (-TURN, 0.0, TURN) if limits.endless[j] else (0.0,)
            places.append([t for t in turns if limits.lower[j] <= q[j] + t <= limits.upper[j]])
        return [q + np.array(turns) for turns in product(*places)]

    def _measure(self, paths: Sequence[Path]) -> tuple[Vector, float, float]:
        joints, elbow, allowed, rcm = np.zeros(9), 0.0, 0.0, self._planner.config.rcm
        for path in paths:
            samples = path.sample(self._planner.model.chain, self._planner.trocar)
            joints += np.abs(np.diff(samples.q[:, 0], axis=0)).sum(axis=0)
            elbow += float(np.linalg.norm(np.diff(samples.elbow, axis=0), axis=1).sum())
            allowed += rcm.elbow_allowance + rcm.elbow_ratio * path.length
        return joints, elbow, allowed


def measure() -> list[Figure]:
    """Plan from every turn of drawn starts inside the patient."""
    planner = Planner(load_robot(), load_motion_config())
    planner.warm_up()
    turns = Turns(planner)
    ways = [way for q in turns.starts(STARTS, 5) for way in turns.from_each_turn(q, turns.reach)]
    refused = ", ".join(f"{n} {kind}" for kind, n in sorted(turns.refusals.items())) or "none"
    count = len(ways) + sum(turns.refusals.values())
    long = sum(way.excess > np.pi for way in ways)
    note = f"({STARTS} starts, {count} with all their turns; refused: {refused})"
    worst, elbow = max(way.excess for way in ways), [1e3 * way.elbow for way in ways]
    far = sum(way.elbow > way.elbow_allowed for way in ways)
    return [
        resumable.measured(STARTS, "starts", FULL),
        Figure("turns: plans a joint of which goes the long way", long, "", 0, note=note),
        Figure("turns: joint beyond the shortest plan, max", worst, "rad", np.pi),
        Figure("turns: plans whose elbow goes further than allowed", far, "", 0),
        Figure("turns: way of the elbow, max", max(elbow), "mm"),
        Figure(
            "turns: way of the elbow, p99",
            float(np.percentile(elbow, 99)),
            "mm",
        ),
    ]
