# SPDX-License-Identifier: BSD-3-Clause
"""Tension and stiffness of the tissue under a pull, by a Kalman filter over the displacement."""

from __future__ import annotations

import math

SYNCHRONY = 0.004  # [s] by which tension and displacement may be out of step
DRIFT = 5e-4  # [N] per update that the tension changes by itself: vibration, relaxation
BEND, BEND_WAY = 0.5, 1e-3  # share by which the stiffness changes over a way [m]
GATE = 4.0  # standard deviations from the forecast: the tissue is another now
CAUTION = 2.0  # standard deviations above its mean that the stiffness is taken for
STIFFENING = 10.0  # times stiffer that tissue may become at once


class StiffnessEstimate:
    """Filters the tension and finds its slope over the displacement.

    The state is (tension, stiffness): a displacement ds changes the tension by stiffness * ds, and
    the stiffness by chance (Kalman 1960). Where the measured tension is further from the forecast
    than noise explains, the stiffness counts as unknown again, so sudden stiffening shows at once.

    Args:
        lowest: Never below [N/m].
        highest: Of tissue of which nothing is known yet [N/m].
        noise: Standard deviation of the measured tension [N].
    """

    def __init__(self, lowest: float, highest: float, noise: float) -> None:
        self._lowest, self.highest, self._noise = lowest, highest, noise
        self._s: float | None = None
        self.force = 0.0  # [N] filtered
        self.value = 0.5 * highest  # [N/m]; with the deviation below, `cautious` is `highest`
        self._unknown = (0.5 * highest / CAUTION) ** 2
        self._var_force, self._covariance, self._var_value = noise * noise, 0.0, self._unknown

    @property
    def cautious(self) -> float:
        """Stiffness that the tissue hardly exceeds [N/m]."""
        return self.value + CAUTION * math.sqrt(self._var_value)

    def update(self, s: float, force: float, speed: float) -> None:
        """Take in one measured tension.

        Args:
            s: Displacement when it arose [m].
            force: The tension [N].
            speed: Of s [m/s].
        """
        if self._s is None:
            self._s, self.force = s, force
            return
        ds, self._s = s - self._s, s
        self._forecast(ds)
        slip = self.value * speed * SYNCHRONY
        variance = self._noise * self._noise + slip * slip
        innovation = force - self.force
        if innovation * innovation > GATE * GATE * (self._var_force + variance):
            self._var_value = max(self._unknown, (STIFFENING * self.value) ** 2)
            self._var_force, self._covariance = self._var_force + innovation * innovation, 0.0
        self._correct(innovation, variance)

    def _forecast(self, ds: float) -> None:
        self.force += self.value * ds
        self._var_force += ds * (2.0 * self._covariance + ds * self._var_value) + DRIFT * DRIFT
        self._covariance += ds * self._var_value
        self._var_value += abs(ds) / BEND_WAY * (BEND * self.value) ** 2

    def _correct(self, innovation: float, variance: float) -> None:
        total = self._var_force + variance
        gain_force, gain_value = self._var_force / total, self._covariance / total
        self.force += gain_force * innovation
        value = self.value + gain_value * innovation
        self.value = min(max(value, self._lowest), STIFFENING * self.highest)
        self._var_value = max(0.0, self._var_value - gain_value * self._covariance)  # rounding
        self._covariance -= gain_value * self._var_force
        self._var_force -= gain_force * self._var_force
