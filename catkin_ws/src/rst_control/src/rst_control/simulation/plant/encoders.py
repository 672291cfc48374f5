# SPDX-License-Identifier: BSD-3-Clause
"""Encoders: positions in steps and with noise, velocities from their differences, smoothed."""

from __future__ import annotations

import numpy as np

from rst_control.config.plant import EncodersConfig
from rst_control.types import Vector


class Encoders:
    """Reads joints.

    Args:
        config: Step, noise and smoothing.
        position: At the start [rad]. Shape (n,).
        step: Time between two readings [s].
        random: Of the noise.
    """

    def __init__(
        self, config: EncodersConfig, position: Vector, step: float, random: np.random.Generator
    ) -> None:
        self._unit = np.maximum(np.array(config.step), 1e-15)
        self._noise, self._random = np.array(config.noise), random
        self._time, self._share = step, 1.0 - float(np.exp(-step / config.velocity_time))
        self.position, self.velocity = self._quantised(position), np.zeros(len(position))

    def read(self, position: Vector) -> tuple[Vector, Vector]:
        """Positions [rad] and velocities [rad/s] as read from true positions; shapes (n,)."""
        before = self.position
        noise = self._noise * self._random.standard_normal(len(position))
        self.position = self._quantised(position + noise)
        speed = (self.position - before) / self._time
        self.velocity = self.velocity + self._share * (speed - self.velocity)
        return self.position, self.velocity

    def _quantised(self, position: Vector) -> Vector:
        steps: Vector = self._unit * np.round(position / self._unit)
        return steps
