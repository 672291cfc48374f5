# SPDX-License-Identifier: BSD-3-Clause
"""The limits that every planned path keeps, each with the error that names what breaks it.

A value that is not a number breaks its limit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rst_control.config import MotionConfig
from rst_control.errors import InsertionOutOfRange, LongWay, OutsideWorkspace, TrocarDrift
from rst_control.kinematics import manipulability
from rst_control.kinematics.joint_limits import PLAN_NAMES, JointLimits
from rst_control.kinematics.robot_model import RobotModel
from rst_control.planning.collision import CollisionModel
from rst_control.trajectory.path import Samples
from rst_control.types import Vector

Array = NDArray[np.float64]


class PathChecks:
    """Checks paths through one trocar. It never changes.

    Args:
        model: The robot.
        config: Scene and tolerances.
        limits: Of the joints.
        collisions: Keep tool, arm, base and table apart.
        trocar: Base frame, [m]. Shape (3,).
    """

    def __init__(
        self,
        model: RobotModel,
        config: MotionConfig,
        limits: JointLimits,
        collisions: CollisionModel,
        trocar: Vector,
    ) -> None:
        self._model, self._config, self._trocar = model, config, trocar
        self._limits, self._collisions = limits, collisions
        self._centre = np.array(config.scene.workspace_centre)

    def all(self, samples: Samples) -> None:
        """Check all limits.

        Raises:
            Infeasible: The path breaks one; the error says which.
        """
        self.insertion(samples)
        self.workspace(samples.tip)
        self.posture(samples)  # from here on, limits that depend on the elbow
        self.detour(samples)
        self.rcm(samples)  # last: what strays does so near a singularity, mostly

    def seating(self, samples: Samples) -> None:
        """Check a way back into the trocar: it leads there, and never further off than it began.

        Raises:
            Infeasible: The path breaks a limit; the error says which.
        """
        self.posture(samples)
        planned = self._config.rcm.planned_tolerance
        error = samples.rcm_error
        for worst, allowed in ((error.max(), error[0] + planned), (error[-1], planned)):
            if not worst <= allowed:
                raise TrocarDrift(float(worst), float(allowed))

    def posture(self, samples: Samples) -> None:
        """Check joint limits, collisions and singularities.

        Raises:
            Infeasible: The path breaks one; the error says which.
        """
        self.joints(samples)
        self._collisions.check(samples)
        self.manipulability(samples.q[:, 0])

    def manipulability(self, q: Array) -> None:
        """Check joints (n, 9) [rad], near to each other.

        Raises:
            NearSingular: Somewhere there is too little manipulability.
        """
        least = self._config.limits.min_manipulability
        manipulability.check(self._model.chain, q, self._trocar, least)

    def workspace(self, tip: Array) -> None:
        """Check places of the tip, base frame, [m]. Shape (3,) or (n, 3).

        Raises:
            OutsideWorkspace: One is outside.
        """
        distance = float(np.linalg.norm(tip - self._centre, axis=-1).max())
        if not distance <= (allowed := self._config.scene.workspace_radius):
            raise OutsideWorkspace(distance, allowed)

    def joints(self, samples: Samples) -> None:
        """Check joint limits.

        Raises:
            JointLimitExceeded: A joint leaves its range.
        """
        for q in (samples.q[:, 0].min(axis=0), samples.q[:, 0].max(axis=0)):
            self._limits.require(q)

    def detour(self, samples: Samples) -> None:
        """Check that joints and elbow move no further than such a way of the tool needs.

        Raises:
            LongWay: One does; with how far, and what is allowed.
        """
        rcm, length = self._config.rcm, float(samples.s[-1])
        turned = np.abs(np.diff(samples.q[:, 0], axis=0)).sum(axis=0)
        worst = int(turned.argmax())
        if not (way := float(turned[worst])) <= rcm.max_joint_way:
            allowed = f"{rcm.max_joint_way:.2f} rad"
            raise LongWay(PLAN_NAMES[worst], f"{way:.2f} rad", length, allowed)
        way = float(np.linalg.norm(np.diff(samples.elbow, axis=0), axis=1).sum())
        if not way <= (most := rcm.elbow_allowance + rcm.elbow_ratio * length):
            raise LongWay("the elbow", f"{way * 1e3:.0f} mm", length, f"{most * 1e3:.0f} mm")

    def rcm(self, samples: Samples) -> None:
        """Check that the shaft stays in the trocar.

        Raises:
            TrocarDrift: It strays further than planning allows.
        """
        allowed = self._config.rcm.planned_tolerance
        if not (worst := float(samples.rcm_error.max())) <= allowed:
            raise TrocarDrift(worst, allowed)

    def insertion(self, samples: Samples) -> None:
        """Check how much of the shaft is inside the trocar.

        Raises:
            InsertionOutOfRange: Too little or too much of it.
        """
        least, most = self._config.rcm.insertion
        depth = self._model.shaft_length - samples.along
        for value in (float(depth.min()), float(depth.max())):
            if not least <= value <= most:
                raise InsertionOutOfRange(value, least, most)
