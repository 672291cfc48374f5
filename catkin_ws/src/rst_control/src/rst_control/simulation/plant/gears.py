# SPDX-License-Identifier: BSD-3-Clause
"""Gears that twist under their load: a joint is off its motor by torque over stiffness."""

from __future__ import annotations

import numpy as np

from rst_control.config.plant import GearsConfig
from rst_control.types import Vector


class Gears:
    """Springs between motors and joints, which settle in a short time; they do not swing.

    Zero is the twist under the load at the start: arm and trocar were calibrated under it.

    Args:
        config: Stiffness and time to settle.
        load: Torques that hold the joints at the start [N m]. Shape (7,).
        step: Time of one `advance` [s].
    """

    def __init__(self, config: GearsConfig, load: Vector, step: float) -> None:
        self._stiffness, self._first = np.array(config.stiffness), np.array(load)
        self._share = 1.0 - float(np.exp(-step / config.settle_time))
        self.twist = np.zeros(len(load))  # [rad] of the joints ahead of their motors

    def advance(self, load: Vector) -> Vector:
        """Twist [rad] after one step under torques that hold the joints [N m]; shapes (7,)."""
        settled = (self._first - load) / self._stiffness
        self.twist = self.twist + self._share * (settled - self.twist)
        return self.twist
