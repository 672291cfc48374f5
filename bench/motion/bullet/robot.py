# SPDX-License-Identifier: BSD-3-Clause
"""A PyBullet world of its own with the robot in it, for judges that trust nothing of ours."""

from __future__ import annotations

from rst_control.config import URDF_FILE
from rst_control.simulation.physics import BulletWorld, load_robot


class BulletRobot(BulletWorld):
    """The robot without physics; a context manager."""

    def __init__(self) -> None:
        super().__init__()
        self._robot = load_robot(URDF_FILE, self._client)
