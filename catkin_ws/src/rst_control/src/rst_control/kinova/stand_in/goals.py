# SPDX-License-Identifier: BSD-3-Clause
"""Goals of FollowJointTrajectory as the driver's core sees them, without ROS's handles."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from rst_control.kinova.stand_in.waypoints import Point

SUCCESSFUL = 0
PATH_TOLERANCE_VIOLATED = -4  # also what a goal missed in time gets


class GoalState(Enum):
    """Of actionlib's states those that the driver uses."""

    ACTIVE = "active"
    PREEMPTING = "preempting"
    OTHER = "other"


@dataclass(frozen=True, eq=False)
class Goal:
    """What a client asks for, as far as the driver uses it."""

    joint_names: tuple[str, ...]
    points: tuple[Point, ...]
    time_tolerance: float  # [s]; 0: as the driver was set up


class GoalHandle(Protocol):
    """A goal and the way to answer it."""

    @property
    def goal(self) -> Goal:
        """What was asked for."""
        ...

    @property
    def state(self) -> GoalState:
        """Where it stands by now."""
        ...

    def reject(self) -> None:
        """Refuse it; no code and no words go with that."""
        ...

    def accept(self) -> None:
        """Take it up."""
        ...

    def succeed(self, code: int) -> None:
        """End it well."""
        ...

    def abort(self, code: int, words: str) -> None:
        """End it badly."""
        ...

    def cancel(self) -> None:
        """End it as its client asked for."""
        ...
