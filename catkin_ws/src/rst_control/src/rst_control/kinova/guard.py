# SPDX-License-Identifier: BSD-3-Clause
"""Stops the arm when the sender of its velocities falls silent: the arm itself never would.

The driver has no watchdog on velocities (ros_kortex issue 159), so a bridge that dies in motion
would leave the arm turning. This runs in a process of its own, so small that there is little in it
to die of.
"""

from __future__ import annotations

from rst_control.kinova.config import GuardConfig


class StopGuard:
    """Decides when to stop the arm.

    Args:
        config: Silence that is allowed, and how stops are repeated.
    """

    def __init__(self, config: GuardConfig) -> None:
        self._config = config
        self._heard: float | None = None  # [s] of the last beat; None: never, or long ago
        self._stopped = 0.0

    def heard(self, now: float) -> None:
        """Note a beat of the bridge."""
        self._heard = now

    def is_silent(self, now: float) -> bool:
        """Whether the bridge was there, and is silent now."""
        return self._heard is not None and now - self._heard > self._config.silence

    def is_stop_due(self, now: float) -> bool:
        """Whether the arm has to be stopped now; repeated for a while, then left alone.

        Somebody may have to move the arm by other means once the bridge is gone.
        """
        if self._heard is None or not self.is_silent(now):
            return False
        if now - self._heard > self._config.silence + self._config.insist:
            self._heard = None
            return False
        if now - self._stopped < self._config.repeat:
            return False
        self._stopped = now
        return True
