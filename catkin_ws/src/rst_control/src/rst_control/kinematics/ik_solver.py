# SPDX-License-Identifier: BSD-3-Clause
"""Inverse kinematics: joint angles for a tool pose with the shaft through the trocar."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rst_control.config import SolverConfig
from rst_control.kinematics import constrained_ik
from rst_control.kinematics.joint_limits import JointLimits
from rst_control.kinematics.robot_model import RobotModel
from rst_control.types import Vector, frozen_array

Array = NDArray[np.float64]

ARM_WEIGHT = 1.0  # pull of each arm joint to the reference posture; the wrist follows the task
SEED = 20211  # of the starts tried from cold, so that the same pose gives the same answer
WRIST_SEEDS = 1.0  # [rad] starts spread pitch and yaw this far


@dataclass(frozen=True, eq=False)
class IkResult:
    """What the solver found."""

    q: Vector  # (9,), [rad]; the nearest found where it is not solved
    is_solved: bool  # pose and trocar kept within the tolerance, joints inside their limits
    residual: float  # [m], largest part of pose and trocar missing (a radian counts as 0.1 m)
    starts: int
    iterations: int


class IkSolver:
    """Solves poses for one robot, trocar and set of limits.

    Args:
        model: The robot.
        limits: Joint limits that solutions keep.
        reference: Posture that solutions stay near, [rad]. Shape (9,).
        config: Tolerances and counts.
    """

    def __init__(
        self, model: RobotModel, limits: JointLimits, reference: ArrayLike, config: SolverConfig
    ) -> None:
        self.model, self.limits, self.config = model, limits, config
        self.reference = frozen_array(reference, 9)
        weight = np.array([ARM_WEIGHT] * 7 + [0.0] * 2)
        rows = [self.reference, weight, limits.lower, limits.upper]
        self.posture = frozen_array(rows, 4, 9)
        self._rule = np.array(
            [config.tolerance, config.damping, config.max_step, config.max_iterations]
        )
        self._seeds = self._make_seeds()

    def settle(self, q_start: Vector, T_base_tip: Array, trocar: Vector) -> IkResult:
        """Solve from nearby and swing the elbow to the best posture, without searching elsewhere.

        Args:
            q_start: Where to start, [rad]. Shape (9,).
            T_base_tip: Pose of tool_tip in base_link. Shape (4, 4) or (3, 4).
            trocar: Base frame, [m]. Shape (3,).
        """
        q = np.array(q_start, dtype=np.float64)
        target, posture = np.ascontiguousarray(T_base_tip[:3]), self._posture_near(q)
        missing, iterations = constrained_ik.solve(
            self.model.chain, q, target, trocar, posture, self._rule, True
        )
        return self._result(q, missing, 1, iterations)

    def search(self, T_base_tip: Array, trocar: Vector, q_start: Vector | None = None) -> IkResult:
        """Solve from cold: from `q_start` or the reference, then from all over the joint ranges.

        Args:
            T_base_tip: Pose of tool_tip in base_link. Shape (4, 4) or (3, 4).
            trocar: Base frame, [m]. Shape (3,).
            q_start: First start, [rad]. Shape (9,).
        """
        best, seeds = np.empty(9), self._seeds.copy()
        seeds[0] = self.reference if q_start is None else q_start
        missing, starts, iterations = constrained_ik.search(
            self.model.chain,
            seeds,
            np.ascontiguousarray(T_base_tip[:3]),
            trocar,
            self.posture,
            self._rule,
            best,
        )
        return self._result(best, missing, starts, iterations)

    def _posture_near(self, q: Vector) -> Array:
        """The posture with its reference in the turns of q (9,), held within the limits."""
        turns = self.limits.turns_towards(self.reference, q)
        if not turns.any():
            return self.posture
        posture = self.posture.copy()
        posture[0] = np.clip(self.reference + turns, self.limits.lower, self.limits.upper)
        return posture

    def _result(self, q: Vector, missing: float, starts: int, iterations: int) -> IkResult:
        is_solved = missing < self.config.tolerance and self.limits.violation(q) is None
        if not np.isfinite(q).all():
            q, missing = self.reference, float("inf")
        return IkResult(frozen_array(q, 9), is_solved, missing, starts, iterations)

    def _make_seeds(self) -> Array:
        low = np.maximum(self.limits.lower, -np.pi)
        high = np.minimum(self.limits.upper, np.pi)
        low[7:] = np.maximum(low[7:], -WRIST_SEEDS)
        high[7:] = np.minimum(high[7:], WRIST_SEEDS)
        rng = np.random.default_rng(SEED)
        seeds = rng.uniform(low, high, (self.config.restarts + 1, 9))
        locked = list(self.model.locked)
        seeds[:, locked] = self.reference[locked]
        return seeds
