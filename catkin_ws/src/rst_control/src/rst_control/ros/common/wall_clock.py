# SPDX-License-Identifier: BSD-3-Clause
"""How far the wall clock, which stamps messages, is ahead of the steady one, which controls."""

from __future__ import annotations

import time
from collections.abc import Callable

import rospy

CLOCK_JUMP = 1e-3  # [s] change of the wall clock against the steady one that is taken over
REPORTED = 0.05  # [s] change from which it is reported, since the robot may be held for it
READINGS = 3  # of which the one that took least time counts

Clock = Callable[[], float]


class RosClock:
    """Translates the steady clock, which everything inside uses, into stamps of ROS and back.

    The wall clock is read for every stamp. Two nodes that noticed at their own times that it was
    set would meanwhile take each other's messages for late or early.
    """

    def __init__(self) -> None:
        self._offset = wall_offset()

    def ahead(self) -> float:
        """Wall clock less steady clock [s]."""
        self._offset = followed(self._offset)
        return self._offset

    def stamp(self, steady: float) -> rospy.Time:
        """Stamp of a moment given by time.monotonic() [s]."""
        return rospy.Time.from_sec(max(0.0, steady + self.ahead()))

    def steady(self, stamp: float) -> float:
        """Moment of a stamp [s], as time.monotonic() has it [s]."""
        return stamp - self.ahead()


class ArrivalOffset:
    """How far the wall clock is ahead as a message comes, where its stamp can be read by it.

    A message on its way while the clock is set back carries a stamp of before that: of the future.

    Args:
        ahead: Wall clock less steady clock now [s].
    """

    def __init__(self, ahead: Callable[[], float]) -> None:
        self._ahead, self._last = ahead, ahead()

    def __call__(self) -> float | None:
        """Wall clock less steady clock [s]; None for the first message after it was set back."""
        before, self._last = self._last, self._ahead()
        return self._last if self._last >= before else None


def wall_offset(wall: Clock = time.time, steady: Clock = time.monotonic) -> float:
    """Wall clock less steady clock [s].

    A thread that is put aside between two readings would see a jump that is none; so the wall clock
    is read between two readings of the steady one, several times, and the quickest counts.
    """
    found = []
    for _ in range(READINGS):
        before = steady()
        now = wall()
        after = steady()
        found.append((after - before, now - (before + after) / 2))
    return min(found)[1]


def followed(offset: float, wall: Clock = time.time, steady: Clock = time.monotonic) -> float:
    """The offset in use [s], or the present one once a clock has jumped by more than CLOCK_JUMP."""
    present = wall_offset(wall, steady)
    if abs(present - offset) <= CLOCK_JUMP:
        return offset
    if abs(present - offset) > REPORTED:
        rospy.logwarn(
            "the wall clock was set by %+.3f s: what was stamped before seems late or early, and "
            "the robot may be held for it; all hosts of a robot need the same time",
            present - offset,
        )
    return present
