# SPDX-License-Identifier: BSD-3-Clause
"""Tension and stiffness of the tissue under a pull, by a Kalman filter over the displacement."""

from __future__ import annotations

import math

SYNCHRONY = 0.004  # [s] by which tension and displacement may be out of step
DRIFT = 5e-4  # [N] per update that the tension changes by itself: vibration, relaxation
BEND, BEND_WAY = 0.5, 1e-3  # share by which the stiffness changes over a way [m]
SURPRISE = 4.0  # standard deviations from the forecast: the tissue is another now
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
        self._of_force, self._of_both, self._of_value = noise * noise, 0.0, self._unknown

    @property
    def cautious(self) -> float:
        """Stiffness that the tissue hardly exceeds [N/m]."""
        return self.value + CAUTION * math.sqrt(self._of_value)

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
        spread = self._noise * self._noise + slip * slip
        surprise = force - self.force
        if surprise * surprise > SURPRISE * SURPRISE * (self._of_force + spread):
            self._of_value = max(self._unknown, (STIFFENING * self.value) ** 2)
            self._of_force, self._of_both = self._of_force + surprise * surprise, 0.0
        self._correct(surprise, spread)

    def _forecast(self, ds: float) -> None:
        self.force += self.value * ds
        self._of_force += ds * (2.0 * self._of_both + ds * self._of_value) + DRIFT * DRIFT
        self._of_both += ds * self._of_value
        self._of_value += abs(ds) / BEND_WAY * (BEND * self.value) ** 2

    def _correct(self, surprise: float, spread: float) -> None:
        total = self._of_force + spread
        of_force, of_value = self._of_force / total, self._of_both / total
        self.force += of_force * surprise
        value = self.value + of_value * surprise
        self.value = min(max(value, self._lowest), STIFFENING * self.highest)
        self._of_value = max(0.0, self._of_value - of_value * self._of_both)  # rounding
        self._of_both -= of_value * self._of_force
        self._of_force -= of_force * self._of_force
