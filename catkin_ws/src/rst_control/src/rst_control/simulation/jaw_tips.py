# SPDX-License-Identifier: BSD-3-Clause
"""Where the tips of both jaws are: the compiled chain, walked once for each jaw."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rst_control.kernels import kernel
from rst_control.kinematics import forward
from rst_control.kinematics.robot_model import RobotModel, behind_joint
from rst_control.types import PLAN_COUNT, Vector

Array = NDArray[np.float64]
RIGHT = "joint_finger_right"
FINGER = 8  # row of the finger in `RobotModel.chain`, and its number among the joints to it


class JawTips:
    """Tips of the jaws from the joints, without asking the physics.

    Args:
        model: The robot; its right finger is taken to be as long as the left.
    """

    def __init__(self, model: RobotModel) -> None:
        right = model.chain.copy()
        right[FINGER] = behind_joint(model, model.link_of[RIGHT])[:3]
        self._chains = np.stack([model.chain, right])
        self._scratch = np.empty(PLAN_COUNT), np.empty((12, 3, 4))

    def __call__(self, joints: Vector) -> Array:
        """Tip of the left jaw, of the right jaw, and the point between.

        Args:
            joints: In the order of JOINTS [rad]. Shape (10,).

        Returns:
            Base frame, [m]. Shape (3, 3), one point per row.
        """
        points = np.empty((3, 3))
        _tips(self._chains, joints, *self._scratch, points)
        return points


@kernel
def _tips(chains: Any, joints: Any, q: Any, frames: Any, points: Any) -> None:
    q[:] = joints[:9]
    for jaw in range(2):
        q[FINGER] = joints[FINGER + jaw]
        forward.forward(chains[jaw], q, frames)
        for i in range(3):
            points[jaw, i] = frames[forward.TIP, i, 3]
    for i in range(3):
        points[2, i] = 0.5 * (points[0, i] + points[1, i])
