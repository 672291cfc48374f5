# SPDX-License-Identifier: BSD-3-Clause
"""Joint torques as the arm reports them: those of its motors, made wrong as configured."""

from __future__ import annotations

import numpy as np

from rst_control.kinova.stand_in.config import TorqueConfig
from rst_control.types import Vector

SLOW = 0.005  # [rad/s] below which friction fades, so that a joint at rest has none


class TorqueSensors:
    """Adds offset, friction and noise.

    Args:
        config: How much of each.
    """

    def __init__(self, config: TorqueConfig) -> None:
        self._sign = config.sign
        self._noise, self._offset = np.array(config.noise), np.array(config.offset)
        self._friction = np.array(config.friction)
        self._random = np.random.default_rng(config.seed)

    def __call__(self, effort: Vector, velocity: Vector) -> Vector:
        """One reading [N m], shape (7,).

        Args:
            effort: Torques of the motors, gravity, load and acceleration included [N m].
            velocity: [rad/s].
        """
        friction = self._friction * np.tanh(velocity / SLOW)
        noise = self._noise * self._random.standard_normal(len(effort))
        return self._sign * (effort + self._offset + friction + noise)
