# SPDX-License-Identifier: BSD-3-Clause
"""How the arm is braked along its course by a process that did not make the course.

The driver's own stop slows each joint by itself: the fast joints rest first, the slow ones run on,
and the shaft leaves the trocar by up to 3 mm. So each velocity that the bridge sends leaves behind
what is known of the course. From that, the guard, or a bridge that was held up, makes velocities
that end on the course at rest. The driver's stop follows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rst_control.kinova.config import BridgeConfig
from rst_control.kinova.velocity_ramp import TINY, Ramp, feasible_share, next_due, velocity_for
from rst_control.robot.courses import Curve
from rst_control.types import ARM_COUNT, Vector

SETTLING = 3  # periods in which the arm reaches the place where it comes to rest


@dataclass(frozen=True, eq=False)
class LastCourse:
    """Arm and course when a velocity was sent; each array of shape (7,)."""

    time: float  # [s] when it was sent
    position: Vector  # [rad] of the arm then, as predicted
    velocity: Vector  # [rad/s] of the arm then
    sent: Vector  # [rad/s]
    goal: Vector  # [rad] of the course one period later
    speed: Vector  # [rad/s] of the course there
    bend: Vector  # [rad/s^2] of the course there, square to its speed


class BrakePlan:
    """Velocities that brake the arm along its course. One process steps it.

    Each leads the arm, from where it is predicted to be, to a place on the course. That place is as
    far ahead as the arm gets while it slows down. So an arm that is late on its course slows down
    from where it is, instead of catching up first.

    Args:
        config: Of the bridge.
        last: What is known of the course.
        delay: From the newest velocity to the first of these [s].
    """

    def __init__(self, config: BridgeConfig, last: LastCourse, delay: float) -> None:
        self._deceleration = np.array(config.servo.brake_deceleration[:ARM_COUNT])
        self._period, self._acceleration = config.arm.period, np.array(config.arm.acceleration)
        self._course = Curve(last.goal, last.speed, last.bend)
        self._ramp = Ramp(last.time, last.position, last.velocity, last.sent, self._acceleration)
        self._due = last.time + delay
        self._reached = delay - self._period  # [s] on the course, of the arm
        self._end: Vector | None = None  # [rad] where it comes to rest; None: it is still too fast
        self._settling = SETTLING

    @property
    def is_over(self) -> bool:
        """The arm rests."""
        return self._settling == 0

    def pass_over(self, now: float) -> None:
        """Take all velocities before a time [s] as sent by somebody else."""
        while self._due <= now - self._period and not self.is_over:
            self.step(self._due)

    def step(self, now: float) -> Vector | None:
        """The velocity to be sent at a time [s], in rad/s, shape (7,); None: none is due."""
        if now < self._due or self.is_over:
            return None
        self._due = next_due(self._due, now, self._period)
        place, velocity = self._ramp.at(now)
        way = self._goal(place, velocity) - place
        way = way * feasible_share(way, velocity, self._acceleration, self._period)
        speeds = velocity_for(way, velocity, self._acceleration, self._period)
        self._ramp = Ramp(now, place, velocity, speeds, self._acceleration)
        return speeds

    def _goal(self, place: Vector, velocity: Vector) -> Vector:
        """Where the arm should be one period on [rad]."""
        if self._end is not None:
            self._settling -= 1
            return self._end
        slope = self._course.at(self._reached)[1]
        if not slope.any():
            self._end = place
            return place
        away = place - self._course.at(self._reached)[0]
        self._reached += float(away @ slope / (slope @ slope))
        slope = self._course.at(self._reached)[1]
        rate = max(0.0, float(velocity @ slope / (slope @ slope)))  # 1: as fast as on the course
        bend = np.abs(self._course.bend)
        pull = self._deceleration - np.minimum(rate * rate * bend, 0.5 * self._deceleration)
        change = float((pull / np.maximum(np.abs(slope), TINY)).min())  # [1/s] of the rate
        time = min(self._period, rate / change)
        ahead = self._course.at(self._reached + time * (rate - 0.5 * change * time))[0]
        if time < self._period:
            self._end = ahead
        return ahead
