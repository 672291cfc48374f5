# SPDX-License-Identifier: BSD-3-Clause
"""A tool with play in its wrist, seen from a controller for which it has none.

A joint follows its motor only once the play is taken up. So its motor is sent ahead of it by half
the play, in the way in which the joint moves (the inverse of the play operator: Tao and Kokotovic
1996). Where the joint is within its play is unknown at first, and after a load on the jaws. Its
motor then goes to both ends of the play: the joint is where it should be afterwards.

Nothing changes but in motion with empty jaws. A stop leaves the motor where it brakes to.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from rst_control.config import MotionConfig
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.robot.backend import RobotBackend
from rst_control.robot.sent_changes import ChangedRobot
from rst_control.types import PLAN_COUNT, Measurement, Setpoint, State, Vector

TOOL: Final = slice(7, PLAN_COUNT)  # pitch and yaw
REVERSAL: Final = 5e-4  # [rad] of a way back that counts
THERE: Final = 1e-4  # [rad] from an end of the play that counts as reached


class PlayCompensation(ChangedRobot):
    """Sends pitch and yaw ahead by half their play, and takes that from what is measured.

    Args:
        robot: What moves.
        config: Play, how fast it is taken up, and limits of the joints.
        state: What the controller is doing.
    """

    def __init__(
        self, robot: RobotBackend, config: MotionConfig, state: Callable[[], State]
    ) -> None:
        super().__init__(robot, config.controller.tension.delay, state)
        self._config, self._limits = config.controller.tool_play, config.limits
        self._half = 0.5 * np.array(self._config.width)
        self._ahead, self._speed = np.zeros(2), np.zeros(2)  # [rad], [rad/s]
        self._way = np.ones(2)  # of each joint's last motion, -1 or 1
        self._turn: Vector | None = None  # [rad] furthest on that way
        self._seen_ends = np.zeros((2, 2), dtype=bool)  # lower and upper, of each joint
        self._is_loaded = False

    def _taken_in(self, measured: Measurement) -> Measurement:
        """The joints as if there was no play."""
        self._is_loaded = measured.gripped
        if measured.fault or not measured.connected:
            self._seen_ends[:] = False  # it may be homed, which moves the joints in their play
        return self.noted.undone(measured)

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Send a set-point, with the motors ahead of their joints."""
        span = self.noted.span(setpoint.stamp)
        q, opening = planning_joints(setpoint.position)
        self._note_way(q[TOOL])
        self._go_on(span)
        room = np.array([self._limits.pitch, self._limits.finger - 0.5 * opening])
        added = np.zeros(PLAN_COUNT)
        added[TOOL] = np.clip(self._ahead, -room - q[TOOL], room - q[TOOL])
        change = self.noted.add(setpoint.stamp, robot_joints(added, 0.0), span)
        position = setpoint.position + change.position
        velocity = setpoint.velocity + change.velocity
        self._robot.servo_jp(Setpoint(position, velocity, setpoint.stamp))

    def hold(self) -> None:
        """Slow down and stay; the motors stay ahead by what they are."""
        self._speed = np.zeros(2)
        super().hold()

    def _note_way(self, q: Vector) -> None:
        """In which way each joint moves; small ways back do not count."""
        turn = q if self._turn is None else self._turn
        moved = q - turn
        has_turned = moved * self._way < -REVERSAL
        self._way = np.where(has_turned, -self._way, self._way)
        is_further = (moved * self._way > 0.0) | has_turned
        self._turn = np.where(is_further, q, turn)

    def _go_on(self, span: float) -> None:
        """Move the motors on towards where they should be ahead, or let them come to rest."""
        if span == 0.0:  # the stream begins anew, where the robot holds
            self._speed = np.zeros(2)
            return
        if self._is_loaded:
            self._seen_ends[:] = False
        acceleration = self._config.acceleration
        gap = self._goal() - self._ahead
        wanted = np.sign(gap) * np.minimum(self._config.speed, np.sqrt(acceleration * np.abs(gap)))
        if self._state() is not State.MOVING or self._is_loaded:
            wanted = np.zeros(2)
        most = acceleration * span
        self._speed = self._speed + np.clip(wanted - self._speed, -most, most)
        reached = np.clip(self._ahead + span * self._speed, -self._half, self._half)
        self._ahead = reached
        self._seen_ends[:, 0] |= reached <= THERE - self._half
        self._seen_ends[:, 1] |= reached >= self._half - THERE

    def _goal(self) -> Vector:
        """Where the motors should be ahead of their joints [rad]; first at the end behind."""
        behind = np.where(self._way > 0.0, self._seen_ends[:, 0], self._seen_ends[:, 1])
        return np.where(behind, self._way, -self._way) * self._half
