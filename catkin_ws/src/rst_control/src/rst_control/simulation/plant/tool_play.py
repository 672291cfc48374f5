# SPDX-License-Identifier: BSD-3-Clause
"""Play between the tool's motors and its joints: what follows only once the play is taken up."""

from __future__ import annotations

import numpy as np

from rst_control.config.plant import ToolPlayConfig
from rst_control.types import Vector


class ToolPlay:
    """Pitch and yaw behind their motors by up to half the play, either way.

    A load beyond a torque pushes a joint to the other end of its play. The opening of the jaws has
    no play here: jaws that close are driven against each other or the tissue.

    Args:
        config: Play and load.
        position: Of the motors at the start, in the middle of the play [rad]. Shape (n,).
        step: Time of one `advance` [s].
    """

    def __init__(self, config: ToolPlayConfig, position: Vector, step: float) -> None:
        self._half, self._torque = 0.5 * config.width, config.torque
        self._way = config.speed * step
        self.position = np.array(position)

    def advance(self, motor: Vector, load: Vector) -> Vector:
        """Joints [rad] after one step.

        Args:
            motor: Where the motors are [rad]. Shape (n,).
            load: Torque of the load on the joints [N m]. Shape (n,).
        """
        pushed = np.where(np.abs(load) > self._torque, np.sign(load) * self._way, 0.0)
        place = self.position + pushed
        self.position = np.clip(place, motor - self._half, motor + self._half)
        return self.position
