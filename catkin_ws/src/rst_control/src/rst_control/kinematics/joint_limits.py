# SPDX-License-Identifier: BSD-3-Clause
"""Joint limits of the active layer, for the robot's joints and for planning configurations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rst_control.config import LimitsConfig
from rst_control.errors import JointLimitExceeded, RobotModelError
from rst_control.kinematics.robot_model import RobotModel
from rst_control.types import ARM_JOINTS, JOINTS, Vector, frozen_array
from typed_config import require

PLAN_NAMES = (*ARM_JOINTS, "joint_pitch", "yaw")
TURN = 2.0 * np.pi
BEYOND = 1e-3  # [rad] that a limit may be beyond the joint's range in the URDF
ZERO = 1e-9  # [rad] that counts as zero


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits of a planning configuration q, in its order; each of shape (9,), read-only."""

    lower: Vector  # [rad], margin taken off
    upper: Vector  # [rad], margin taken off
    velocity: Vector  # [rad/s]
    acceleration: Vector  # [rad/s^2]

    @cached_property
    def endless(self) -> NDArray[np.bool_]:
        """Joints whose range is more than a turn: one place, several angles. Shape (9,)."""
        return self.upper - self.lower > TURN

    def turns_towards(self, q: Vector, goal: Vector) -> Vector:
        """Whole turns [rad] by which q (9,) comes as near to `goal` (9,) as can be; 0 elsewhere."""
        return np.where(self.endless, TURN * np.round((goal - q) / TURN), 0.0)

    def violation(self, q: Vector) -> JointLimitExceeded | None:
        """What `require` would raise, or None."""
        outside = np.maximum(self.lower - q, q - self.upper)
        worst = int(outside.argmax())
        if outside[worst] <= 0.0:
            return None
        low, high = float(self.lower[worst]), float(self.upper[worst])
        return JointLimitExceeded(PLAN_NAMES[worst], float(q[worst]), low, high)

    def require(self, q: Vector) -> None:
        """Check a configuration (9,) [rad].

        Raises:
            JointLimitExceeded: The joint furthest outside, with its range.
        """
        if (error := self.violation(q)) is not None:
            raise error


def make_limits(config: LimitsConfig, opening: float) -> JointLimits:
    """Active limits, where jaws may open by `opening` [rad] at any yaw."""
    layer, margin = config.active, config.position_margin
    yaw = config.finger - 0.5 * opening
    return JointLimits(
        lower=frozen_array(np.array([*config.arm_lower, -config.pitch, -yaw]) + margin, 9),
        upper=frozen_array(np.array([*config.arm_upper, config.pitch, yaw]) - margin, 9),
        velocity=frozen_array([*layer.arm_velocity, *[layer.tool_velocity] * 2], 9),
        acceleration=frozen_array([*layer.arm_acceleration, *[layer.tool_acceleration] * 2], 9),
    )


def require_ranges(config: LimitsConfig, model: RobotModel) -> None:
    """Keep position limits within the ranges of the joints that the URDF calls revolute.

    A joint that the arm lacks may have no room but for the margin.

    Raises:
        RobotModelError: They are beyond one; names the joint and both ranges.
    """
    tool = np.array([config.pitch, config.finger, config.finger])
    lows, highs = [*config.arm_lower, *-tool], [*config.arm_upper, *tool]
    margin = config.position_margin
    for name, low, high in zip(JOINTS, lows, highs, strict=True):
        link = model.links[model.link_of[name]]
        lower, upper, why = link.lower, link.upper, "its range in the URDF"
        if link.type == "fixed":
            lower, upper, why = -margin, margin, "the margin of a joint that the arm lacks"
        if link.type != "continuous" and max(lower - low, high - upper) > BEYOND:
            raise RobotModelError(
                f"limits of {name} from {low:g} to {high:g} rad, allowed: {why}, "
                f"{lower:g} to {upper:g} rad"
            )


def require_lacking_at_zero(what: str, q: Sequence[float] | Vector, model: RobotModel) -> None:
    """Keep joints that the arm lacks at zero.

    Args:
        what: Name of q in the settings.
        q: Joints, the arm's first [rad].
        model: The robot.

    Raises:
        ConfigError: One is not; names the joint.
    """
    for joint in model.locked:
        angle, key = float(q[joint]), f"{what} of {ARM_JOINTS[joint]}"
        require(abs(angle) <= ZERO, key, angle, "0, since the arm lacks it")
