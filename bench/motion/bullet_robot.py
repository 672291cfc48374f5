# SPDX-License-Identifier: BSD-3-Clause
"""A PyBullet connection of its own with the robot in it, for judges that trust nothing of ours."""

from __future__ import annotations

from types import TracebackType
from typing import Self

import pybullet

from rst_control.backends.physics import load_robot
from rst_control.config import URDF_FILE


class BulletRobot:
    """The robot without physics; a context manager."""

    def __init__(self) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        self._robot = load_robot(URDF_FILE, self._client)

    def close(self) -> None:
        """End the connection; calling it twice does no harm."""
        if self._client >= 0:
            pybullet.disconnect(self._client)
            self._client = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
