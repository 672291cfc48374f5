# SPDX-License-Identifier: BSD-3-Clause
"""What keeps arm and tool from being led: drivers, guard, torques at rest, the tool's homing."""

from __future__ import annotations

from typing import Final

import numpy as np

from rst_control.kinova.arm_state import ArmWatch
from rst_control.kinova.brake_plan import LastCourse
from rst_control.kinova.config import BridgeConfig
from rst_control.kinova.feedback import JointFeedback
from rst_control.kinova.tool import Tool
from rst_control.tension.gravity_check import RestTorques

STARTING: Final = "the arm's driver never reported its joints: is it running?"
NO_GUARD: Final = (
    "the stop guard was never heard: start the node kinova_guard; "
    "one that runs does not hear this bridge (ROS_IP, guard.bridge), "
    "or the arm's driver does not hear it (arm:=, ROS_IP)"
)
HELD_TO_HOME: Final = 'the arm is held to home the tool: when it is homed, say "hey robot"'


class Readiness:
    """Knows what was heard last of each; one thread calls it.

    Args:
        config: How old each may be.
        tool: Of the arm.
        watch: Judges what the arm reports of itself.
        torques: Compared with gravity's before the first motion; None: nothing is compared.
    """

    def __init__(
        self, config: BridgeConfig, tool: Tool, watch: ArmWatch, torques: RestTorques | None
    ) -> None:
        self._config, self._tool, self._watch, self.torques = config, tool, watch, torques
        self.arm: JointFeedback | None = None
        self.guard = -np.inf  # [s] of the guard's last beat

    def is_repeated(self, feedback: JointFeedback) -> bool:
        """Whether it is the last one once more, after a gap, which says nothing of the arm.

        Where a reply of the arm is lost, the driver waits, then reports what it had before.
        """
        last = self.arm
        if last is None or feedback.stamp - last.stamp <= self._config.arm.feedback_age:
            return False
        return all(
            np.array_equal(getattr(last, row), getattr(feedback, row))
            for row in ("position", "velocity", "effort")
        )

    def is_at_rest(self, now: float) -> bool:
        """Whether the arm is measured at rest, by joints that are not old at a time [s]."""
        arm, config = self.arm, self._config.arm
        if arm is None or now - arm.stamp > config.feedback_age:
            return False
        return float(np.abs(arm.velocity).max()) <= config.rest_speed

    def shows_stop(self, sent: float, now: float) -> bool:
        """Whether the arm is measured at rest by joints that can know of a stop sent before [s]."""
        arm, config = self.arm, self._config.arm
        knows = sent + config.lag + 1.0 / config.feedback_rate
        return arm is not None and arm.stamp >= knows and self.is_at_rest(now)

    def is_led_at_rest(self, last: LastCourse | None, now: float) -> bool:
        """Whether the arm's course stands still, and the arm with it, at a time [s]."""
        if last is None or last.speed.any():
            return False
        sent = float(np.abs(last.sent).max())  # not zero where it makes up for the joints' noise
        return sent <= self._config.arm.rest_speed and self.is_at_rest(now)

    def hears_guard(self, now: float) -> bool:
        """Whether the guard's last beat is not too old at a time [s]."""
        return now - self.guard <= self._config.guard.silence

    def objection(self, now: float) -> str:
        """Why the arm may not be led at a time [s]; empty: it may."""
        if self.arm is None:
            return STARTING
        age, allowed = now - self.arm.stamp, self._config.arm.feedback_age
        if age > allowed:
            return f"joints of the arm {age * 1e3:.0f} ms old, allowed {allowed * 1e3:.0f} ms"
        if (cause := self._watch.objection(now)) is not None:
            return cause.coded
        torques = self.torques.refusal if self.torques is not None else ""
        return torques or self._unguarded(now) or self._tool.objection(now)

    def _unguarded(self, now: float) -> str:
        guard = self._config.guard
        if not guard.is_required:
            return ""
        if not np.isfinite(self.guard):
            return NO_GUARD
        if self.hears_guard(now):
            return ""
        silent = now - self.guard
        return f"the stop guard is silent for {silent:.2f} s, allowed {guard.silence:.2f} s"
