# SPDX-License-Identifier: BSD-3-Clause
"""An arm whose servo yields to friction, sent beyond its set-points by what it was measured off.

With e what a joint is short of its set-point, it is sent on by gain times e: the servo resists with
1 + gain times its stiffness. Nothing is summed up, so nothing hunts around a joint that sticks.
What a gear twists by is not made up for: encoders at the motors do not see it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from rst_control.config import MotionConfig
from rst_control.robot.backend import RobotBackend
from rst_control.robot.sent_changes import ChangedRobot
from rst_control.types import ACTIVE_STATES, JOINT_COUNT, Measurement, Setpoint, State, Vector

ARM: Final = 7  # joints that are corrected


class JointCorrection(ChangedRobot):
    """Corrects the arm's joints while the controller is active; a latch lets that fade.

    Args:
        robot: What moves.
        config: Gain and limits; `tension.delay` is from a set-point to its measurement.
        state: What the controller is doing.
    """

    def __init__(
        self, robot: RobotBackend, config: MotionConfig, state: Callable[[], State]
    ) -> None:
        super().__init__(robot, config.controller.tension.delay, state)
        self._config = config.controller.joint_correction
        self._short = np.zeros(ARM)  # [rad] of the joints behind it
        self.added = np.zeros(JOINT_COUNT)  # [rad] to the last set-point

    def _taken_in(self, measured: Measurement) -> Measurement:
        """The joints as they are; sent to where the controller sent them."""
        time = measured.stamp - self._lag
        sent = self.noted.at(time)
        if np.isfinite(sent.stamp):
            course = sent.position + (time - sent.stamp) * sent.velocity
            self._short = (course - measured.position)[:ARM]
        rest = measured.sent_to
        return measured if rest is None else replace(measured, sent_to=rest - self.added)

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Send a set-point, and the arm beyond it."""
        span = self.noted.span(setpoint.stamp)
        if span == 0.0:  # what the former set-points led to says nothing of these
            self.noted.start(setpoint.position)
            self._short = np.zeros(ARM)
        self.noted.add(setpoint.stamp, setpoint.position, span)
        change = np.zeros(JOINT_COUNT)
        change[:ARM] = self._change(span)
        self.added = self.added + change
        position = setpoint.position + self.added
        self._robot.servo_jp(Setpoint(position, setpoint.velocity, setpoint.stamp))

    def _change(self, span: float) -> Vector:
        """Of what is added in a time [s], [rad]; shape (7,)."""
        config, wanted = self._config, np.zeros(ARM)
        if self._state() in ACTIVE_STATES:
            wanted = np.clip(config.gain * self._short, -config.limit, config.limit)
        most = config.speed * span
        change: Vector = np.clip(wanted - self.added[:ARM], -most, most)
        return change
