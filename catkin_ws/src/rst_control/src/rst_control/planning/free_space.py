# SPDX-License-Identifier: BSD-3-Clause
"""Paths outside the patient, from the present joints to a given configuration.

A straight joint motion is tried first, then one by way of a place further out, then a search. All
are checked everywhere for collisions and for the patient's surface.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rst_control.errors import Collision, Infeasible
from rst_control.kinematics import forward
from rst_control.kinematics.joint_limits import JointLimits
from rst_control.kinematics.robot_model import RobotModel
from rst_control.planning import rrt_connect
from rst_control.planning.collision import CollisionModel
from rst_control.trajectory.path import Path
from rst_control.types import Vector

Array = NDArray[np.float64]

SEED: Final = 20211  # the same question gets the same answer
SAMPLES: Final = 4000  # that the search tries
NODES: Final = 6000  # of each tree
STEP: Final = 0.5  # [m] of motion by one edge of the search, at most
SHORTCUTS: Final = 150
BESIDE: Final = 1.0  # [rad] that a joint without ends may swing beyond start and goal
STATIONS: Final = 24  # along each leg, to measure how far parts of the robot travel
SAME: Final = 1e-6  # [rad] of joint motion that is none
MIN_RADIUS: Final = 0.03  # [m] at which a joint's turning counts as way where nothing travels
LIFTS: Final = 6  # steps of backing off before the second try
LIFT: Final = 0.025  # [m] of each
DAMPING: Final = 0.02  # [m] of the steps' least squares


class NoWay(Infeasible):
    """No way was found round what is between start and goal."""

    def __init__(self, blocked: Collision, samples: int) -> None:
        super().__init__(f"the straight way is blocked ({blocked}), and {samples} tries found none")
        self.blocked, self.samples = blocked, samples


class Approach:
    """Plans motion wholly outside the patient. It never changes.

    Args:
        model: The robot.
        limits: Joint limits.
        shapes: What must keep apart, the patient's surface included.
        outward: Away from the patient, base frame. Shape (3,).
    """

    def __init__(
        self, model: RobotModel, limits: JointLimits, shapes: CollisionModel, outward: Vector
    ) -> None:
        self._chain, self._limits, self._collisions = model.chain, limits, shapes
        self._outward = outward
        rng = np.random.default_rng(SEED)
        self._rolls = rng.uniform(size=(SAMPLES, 9))
        self._shares = np.sort(rng.uniform(size=(SHORTCUTS, 2)), axis=1)

    def way(self, q: Vector, goal: Vector) -> tuple[Path, ...]:
        """Straight joint motions from q (9,) to the goal (9,) [rad].

        Raises:
            Infeasible: Start or goal is no place to be, or no way was found; says what blocks.
        """
        for end in (q, goal):
            self.require_place(end)
        try:
            return self._legs((q, goal))
        except Collision as blocked:
            try:
                return self._legs((q, self._lifted(q), self._lifted(goal), goal))
            except Collision:
                corners = self._search(q, goal)
            if corners is None:
                raise NoWay(blocked, SAMPLES) from None
            return self._legs(corners)

    def warm_up(self, q: Vector) -> None:
        """Compile or load every kernel, by a search from q (9,) to itself."""
        self._search(q, q)
        self._lifted(q)

    def require_place(self, q: Vector) -> None:
        """Check a configuration (9,) [rad].

        Raises:
            Infeasible: A joint is beyond its limit, or something is too near something.
        """
        self._limits.require(q)
        found = self._collisions.clearance(q)
        if not found.distance >= found.allowed:
            raise Collision(found.first, found.second, found.distance, found.allowed)

    def _legs(self, corners: tuple[Vector, ...]) -> tuple[Path, ...]:
        paths = [self.leg(a, b) for a, b in pairwise(corners) if np.abs(b - a).max() > SAME]
        for path in paths:
            self._collisions.check(path.sample(self._chain, np.zeros(3)))
        return tuple(paths)

    def leg(self, a: Vector, b: Vector) -> Path:
        """Joint motion straight from a to b (9,), as long as the part that travels furthest."""
        places, frames = np.empty((STATIONS + 1, 12, 3)), np.empty((12, 3, 4))
        for k in range(STATIONS + 1):
            forward.forward(self._chain, a + k / STATIONS * (b - a), frames)
            places[k] = frames[:, :, 3]
        travelled = np.linalg.norm(np.diff(places, axis=0), axis=2).sum(axis=0)
        turned = float(np.abs(b - a).max()) * MIN_RADIUS
        length = max(float(travelled.max()), turned)
        slope = (b - a) / length
        return Path(np.array([a, b]), np.array([slope, slope]), length)

    def _lifted(self, q: Vector) -> Vector:
        """Joints (9,) with the tip further from the patient, by damped least squares."""
        q, frames, J = np.array(q), np.empty((12, 3, 4)), np.empty((6, 9))
        for _ in range(LIFTS):
            forward.forward(self._chain, q, frames)
            forward.tip_jacobian(frames, 1.0, J)
            square = J[:3] @ J[:3].T + DAMPING**2 * np.eye(3)
            q += J[:3].T @ np.linalg.solve(square, LIFT * self._outward)
        return np.clip(q, self._limits.lower, self._limits.upper)

    def _search(self, q: Vector, goal: Vector) -> tuple[Vector, ...] | None:
        shapes, ends = self._collisions.shapes, np.array([q, goal])
        nodes, parents = np.empty((2, NODES, 9)), np.zeros((2, NODES), dtype=np.int64)
        samples = self._samples(ends)
        meeting = rrt_connect.connect(self._chain, shapes, ends, samples, STEP, nodes, parents)
        if meeting[0] < 0:
            return None
        first, second = (_branch(nodes[k], parents[k], meeting[k]) for k in range(2))
        way = np.array([*reversed(first), *second[1:]])  # both hold the place where they met
        count = rrt_connect.shortcut(self._chain, shapes, way, self._shares)
        return tuple(way[:count])

    def _samples(self, ends: Array) -> Array:
        """Configurations all over the joint ranges, but near the ends where a range is endless."""
        low, high = self._limits.lower.copy(), self._limits.upper.copy()
        endless = self._limits.endless.copy()
        endless[7:] = True  # the wrist need not bend on the way, either
        beside = np.where(np.arange(9) < 7, BESIDE, 0.0)
        low[endless] = np.maximum(low, ends.min(axis=0) - beside)[endless]
        high[endless] = np.minimum(high, ends.max(axis=0) + beside)[endless]
        return low + self._rolls * (high - low)


def _branch(nodes: Array, parents: NDArray[np.int64], leaf: int) -> list[Vector]:
    """Nodes from a leaf to the root of its tree."""
    branch = [nodes[leaf]]
    while leaf:
        leaf = int(parents[leaf])
        branch.append(nodes[leaf])
    return branch
