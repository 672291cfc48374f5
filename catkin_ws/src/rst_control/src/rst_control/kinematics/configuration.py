# SPDX-License-Identifier: BSD-3-Clause
"""A planning configuration: immutable q with the frames and Jacobians that belong to it.

q is joint_1 to joint_7, pitch and yaw. The robot's two jaws are yaw and opening: `robot_joints`,
`planning_joints`.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rst_control.kinematics import forward
from rst_control.kinematics.robot_model import RobotModel
from rst_control.types import JOINT_COUNT, PLAN_COUNT, Vector, frozen_array

Array = NDArray[np.float64]


def robot_joints(q: Vector, opening: float) -> Vector:
    """Joints of the robot for a planning configuration.

    The axes of the two fingers point opposite ways, so turning both jaws together takes opposite
    signs.

    Args:
        q: Planning configuration [rad]. Shape (9,).
        opening: Angle between the jaws [rad].

    Returns:
        Joints in the order of `types.JOINTS` [rad]. Shape (10,).
    """
    joints = np.empty(JOINT_COUNT)
    joints[:8] = q[:8]
    joints[8] = q[8] + 0.5 * opening
    joints[9] = 0.5 * opening - q[8]
    return joints


def planning_joints(joints: Vector) -> tuple[Vector, float]:
    """Planning configuration (9,) and opening [rad] of robot joints (10,); for velocities, too."""
    q = np.empty(PLAN_COUNT)
    q[:8] = joints[:8]
    q[8] = 0.5 * (joints[8] - joints[9])
    return q, float(joints[8] + joints[9])


class Configuration:
    """The robot at q; frames and Jacobians are computed once, when first asked for.

    Args:
        model: The robot.
        q: Planning configuration [rad]. Shape (9,). Copied.
    """

    def __init__(self, model: RobotModel, q: ArrayLike) -> None:
        self.model = model
        self.q = frozen_array(q, PLAN_COUNT)

    @cached_property
    def frames(self) -> Array:
        """Poses of all frames of forward.py in base_link [m]. Shape (12, 3, 4), read-only."""
        frames = np.empty((12, 3, 4))
        forward.forward(self.model.chain, self.q, frames)
        frames.flags.writeable = False
        return frames

    @property
    def T_base_tip(self) -> Array:
        """Pose of tool_tip in base_link. Shape (4, 4)."""
        return _homogeneous(self.frames[forward.TIP])

    @property
    def T_base_shaft(self) -> Array:
        """Pose of interface_link in base_link; the shaft is its z axis. Shape (4, 4)."""
        return _homogeneous(self.frames[forward.SHAFT])

    @property
    def tip(self) -> Vector:
        """Tool tip, base frame, [m]. Shape (3,)."""
        return self.frames[forward.TIP, :, 3].copy()

    @cached_property
    def J_tip(self) -> Array:
        """Jacobian of tool_tip, base frame: linear [m/rad], then angular [-]. Shape (6, 9)."""
        J = np.empty((6, PLAN_COUNT))
        forward.tip_jacobian(self.frames, 1.0, J)
        J.flags.writeable = False
        return J


def _homogeneous(frame: Array) -> Array:
    return np.vstack([frame, [0.0, 0.0, 0.0, 1.0]])
