# SPDX-License-Identifier: BSD-3-Clause
"""A PyBullet world of its own with the robot in it, for judges that trust nothing of ours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pybullet
from numpy.typing import NDArray

from rst_control.config import URDF_FILE
from rst_control.simulation.physics import BulletWorld, joint_indices, link_indices, load_robot

Array = NDArray[np.float64]


class BulletRobot(BulletWorld):
    """The robot without physics; a context manager.

    Args:
        urdf: That PyBullet reads.
    """

    def __init__(self, urdf: Path = URDF_FILE) -> None:
        super().__init__()
        self._robot = load_robot(urdf, self._client)
        self._joints = joint_indices(self._robot, self._client)
        self._links = link_indices(self._robot, self._client)

    def place(self, joints: Array) -> None:
        """Put the robot's joints (10,) [rad] where they are asked for."""
        values = [[float(value)] for value in joints]
        pybullet.resetJointStatesMultiDof(
            self._robot, self._joints, values, physicsClientId=self._client
        )

    def poses(self, links: Sequence[str]) -> Array:
        """Where links are in base_link, in single precision. Shape (n, 3, 4)."""
        numbers = [self._links[name] for name in links]
        states = pybullet.getLinkStates(
            self._robot, numbers, computeForwardKinematics=1, physicsClientId=self._client
        )
        turns = [pybullet.getMatrixFromQuaternion(state[5]) for state in states]
        places = [np.array(state[4])[:, None] for state in states]
        return np.array(
            [np.hstack([np.reshape(R, (3, 3)), p]) for R, p in zip(turns, places, strict=True)]
        )
