# SPDX-License-Identifier: BSD-3-Clause
"""A robot whose set-points are changed on their way, and its measurements on theirs back."""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from rst_control.robot.backend import RobotBackend
from rst_control.types import JOINT_COUNT, Measurement, State, Vector

LONGEST: Final = 0.02  # [s] between two set-points of one stream
KEPT: Final = 0.5  # [s] of changes that are remembered
STILL: Final = np.zeros(JOINT_COUNT)


@dataclass(frozen=True, eq=False)
class Change:
    """By what set-points differed from what the controller sent, at a moment."""

    stamp: float  # [s]
    position: Vector  # (10,), [rad]
    velocity: Vector  # (10,), [rad/s]


class SentChanges:
    """Remembers changes for as long as measurements of them may come.

    Args:
        lag: From a set-point to its measurement [s].
    """

    def __init__(self, lag: float) -> None:
        self._lag = lag
        self._changes = deque([Change(-np.inf, STILL, STILL)])

    @property
    def newest(self) -> Change:
        """The last one."""
        return self._changes[-1]

    def span(self, stamp: float) -> float:
        """Time since the last one [s]; 0 where the stream begins anew."""
        span = max(stamp - self.newest.stamp, 0.0)
        return span if span <= LONGEST else 0.0

    def add(self, stamp: float, position: Vector, span: float) -> Change:
        """Note where the change is now [rad], shape (10,), `span` [s] after the last one."""
        velocity = (position - self.newest.position) / span if span > 0.0 else STILL
        self._changes.append(Change(stamp, position, velocity))
        while self._changes[1].stamp < stamp - KEPT:
            self._changes.popleft()
        return self.newest

    def start(self, position: Vector) -> None:
        """Begin anew, where the robot holds joints that are changed [rad] already. Shape (10,)."""
        self._changes = deque([Change(-np.inf, position, STILL)])

    def rest(self) -> None:
        """Note that the robot holds: the change stays as it is."""
        last = self.newest
        self._changes.append(replace(last, velocity=STILL))

    def undone(self, measured: Measurement) -> Measurement:
        """The measurement as if nothing had been added."""
        change, sent_to = self.at(measured.stamp - self._lag), measured.sent_to
        return replace(
            measured,
            position=measured.position - change.position,
            velocity=measured.velocity - change.velocity,
            sent_to=None if sent_to is None else sent_to - self.newest.position,
        )

    def at(self, stamp: float) -> Change:
        """The change sent at a time [s]; once set-points have ended it stays as it is."""
        last = self.newest
        if stamp > last.stamp + LONGEST:
            return replace(last, velocity=STILL)
        for change in reversed(self._changes):
            if change.stamp <= stamp:
                return change
        return self._changes[0]


class ChangedRobot(RobotBackend):
    """What changes set-points and measurements between a controller and its robot.

    The control loop alone calls it.

    Args:
        robot: What moves.
        lag: From a set-point to its measurement [s].
        state: What the controller is doing.

    Attributes:
        noted: Of the set-points on their way: what was added, or where the controller is.
    """

    def __init__(self, robot: RobotBackend, lag: float, state: Callable[[], State]) -> None:
        self._robot, self._lag, self._state = robot, lag, state
        self.noted = SentChanges(lag)
        self._raw: Measurement | None = None  # the newest, as the robot has it
        self._seen: Measurement | None = None  # the same as the controller has it

    def measured_js(self) -> Measurement | None:
        """What the robot says, as if its set-points had not been changed."""
        measured = self._robot.measured_js()
        if measured is not None and measured is not self._raw:
            self._seen = self._taken_in(measured)
            self._raw = measured
        return self._seen

    @abstractmethod
    def _taken_in(self, measured: Measurement) -> Measurement:
        """Take note of a new measurement; gives it as the controller has it."""

    def hold(self) -> None:
        """Slow down and stay; what was added stays, too."""
        self.noted.rest()
        self._robot.hold()

    def clear_fault(self) -> None:
        """Ask the robot to take set-points again."""
        self._robot.clear_fault()
