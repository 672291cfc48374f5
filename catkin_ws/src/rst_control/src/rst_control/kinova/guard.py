# SPDX-License-Identifier: BSD-3-Clause
"""Brakes and stops the arm when the sender of its velocities falls silent: it never would.

The driver has no watchdog on velocities (ros_kortex issue 159), so a bridge that dies in motion
would leave the arm turning. This runs in a process of its own, so small that there is little in it
to die of.
"""

from __future__ import annotations

from rst_control.kinova.brake_plan import BrakePlan, LastCourse
from rst_control.kinova.config import BridgeConfig
from rst_control.types import Vector


class StopGuard:
    """Decides when to brake and to stop the arm.

    Args:
        config: Of the bridge: silence that is allowed, how the arm is braked, how stops are
            repeated.
    """

    def __init__(self, config: BridgeConfig) -> None:
        self._config, self._all = config.guard, config
        self._last: LastCourse | None = None  # None: the arm is not led
        self._plan: BrakePlan | None = None
        self._heard: float | None = None  # [s] of the last beat; None: never, or long ago
        self._stop_from = 0.0  # [s] from which stops are due
        self._stopped = 0.0

    def heard(self, now: float, last: LastCourse | None = None) -> None:
        """Note a beat of the bridge, with the course on which it leads the arm."""
        self._heard, self._last, self._plan = now, last, None
        self._stop_from = now + self._config.silence

    def speeds_due(self, now: float) -> Vector | None:
        """Velocities that brake the arm along its course [rad/s], shape (7,); None: none now.

        They come before any stop.
        """
        if self._last is None or not self.is_silent(now):
            return None
        if self._plan is None:
            self._plan = BrakePlan(self._all, self._last, now - self._last.time)
        speeds = self._plan.step(now)
        if self._plan.is_over:
            self._last = self._plan = None
            self._stop_from = now
        return speeds

    @property
    def is_braking(self) -> bool:
        """Whether velocities that brake the arm are being sent."""
        return self._plan is not None

    def is_silent(self, now: float) -> bool:
        """Whether the bridge was there, and is silent now."""
        return self._heard is not None and now - self._heard > self._config.silence

    def hears_bridge(self, now: float) -> bool:
        """Whether beats of the bridge come; only then does the bridge have a guard."""
        return self._heard is not None and not self.is_silent(now)

    def is_stop_due(self, now: float) -> bool:
        """Whether the arm has to be stopped now; repeated for a while, then left alone.

        Braking takes nothing of that while. Somebody may have to move the arm by other means once
        the bridge is gone.
        """
        if self._heard is None or self._last is not None or not self.is_silent(now):
            return False
        if now - self._stop_from > self._config.insist:
            self._heard = None
            return False
        if now - self._stopped < self._config.repeat:
            return False
        self._stopped = now
        return True
