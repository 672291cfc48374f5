# SPDX-License-Identifier: BSD-3-Clause
"""A sensor with noise, and with a drift that wanders: an Ornstein-Uhlenbeck process.

Over a time t the drift keeps a share exp(-t / T) of itself, and gains a random part such that its
standard deviation stays (Uhlenbeck and Ornstein 1930).
"""

from __future__ import annotations

import numpy as np

from rst_control.config.plant import ForceErrorConfig, TorqueErrorConfig
from rst_control.types import Vector


class DriftingSensor:
    """Adds noise and drift to what is measured; the drift begins at zero, as after a tare.

    Args:
        config: Standard deviations and time.
        step: Time between two readings [s].
        random: Of both.
    """

    def __init__(
        self, config: TorqueErrorConfig | ForceErrorConfig, step: float, random: np.random.Generator
    ) -> None:
        self._noise, self._random = np.array(config.noise), random
        self._kept = float(np.exp(-step / config.drift_time))
        self._gained = np.array(config.drift) * np.sqrt(1.0 - self._kept**2)
        self.drift = np.zeros(len(self._noise))

    def read(self, true: Vector) -> Vector:
        """One reading; shape (n,)."""
        count = len(self._noise)
        self.drift = self._kept * self.drift + self._gained * self._random.standard_normal(count)
        reading: Vector = true + self.drift + self._noise * self._random.standard_normal(count)
        return reading
