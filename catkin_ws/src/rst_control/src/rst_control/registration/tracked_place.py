# SPDX-License-Identifier: BSD-3-Clause
"""What a tracker reports of a place, and what of it is not believed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Final

import numpy as np

from rst_control.config.tracking import TrackedGraspConfig
from rst_control.kinematics.mounting import angle_between
from rst_control.types import Cause, Reason, Vector

FUTURE: Final = 0.05  # [s] by which a stamp may be ahead: clocks of two hosts differ
ROUNDING: Final = 1e-6  # [s] by which stamps that are steady_time apart may be closer
SAME_WAY: Final = float(np.radians(5.0))  # [rad] between ways of the pull that count as one


@dataclass(frozen=True, eq=False)
class Report:
    """A place as a tracker reports it."""

    place: Vector  # (3,), base frame, [m]
    stamp: float  # [s] steady clock, when it was measured
    pull: tuple[float, ...] = ()  # way of the pull, base frame; (): none is reported
    arrived: float = inf  # [s] steady clock, when it came; infinite: not known

    def is_news(self, last: Report | None) -> bool:
        """Whether it counts after the last one, whose stamp may have been ahead of time."""
        if last is None or self.stamp > last.stamp:
            return True
        return last.stamp > self.arrived + FUTURE


def is_other_way(first: Sequence[float], second: Sequence[float]) -> bool:
    """Whether two ways of the pull (3,) differ; what names none, (), differs from nothing."""
    if not first or not second:
        return False
    return not angle_between(np.array(first), np.array(second)) <= SAME_WAY  # no number is not


def too_old(report: Report, now: float, age: float) -> Cause | None:
    """Why the time of a report forbids to use it; None: it does not."""
    return untimely("tracked place", report.stamp, now, age)


def untimely(
    what: str, stamp: float, now: float, age: float, ahead: float = FUTURE
) -> Cause | None:
    """Why a stamp [s] forbids to use what bears it, old or ahead of time; None: it does not."""
    late = now - stamp
    if late > age:
        return Cause(Reason.TRACKER_STALE, f"{what} {late:.2f} s old, allowed {age:.2f} s")
    if late < -ahead:
        words = f"{what} stamped {-late:.2f} s ahead, allowed {ahead:.2f} s"
        return Cause(Reason.TRACKER_STALE, f"{words}: are the clocks of both hosts set?")
    return None


def too_far(place: Vector, home: Vector, allowed: float) -> Cause | None:
    """Why a place is too far from where it is expected; None: it is not."""
    away = float(np.linalg.norm(place - home))
    if away <= allowed:  # no number is not
        return None
    words = f"tracked place {away * 1e3:.1f} mm from that of scene.yaml"
    return Cause(Reason.TRACKER_TOO_FAR, f"{words}, allowed {allowed * 1e3:.1f} mm")


class SteadyPlace:
    """A place that has to stay where it is for a while before it is taken.

    Args:
        config: How long, how near, and how far from home.
        age: Of a report, at most [s]. A longer gap between two reports begins it anew.
        home: Where it is expected, base frame, [m]. Shape (3,).
    """

    def __init__(self, config: TrackedGraspConfig, age: float, home: Vector) -> None:
        self._config, self._age, self._home = config, age, np.array(home)
        self._reports: tuple[Report, ...] = ()  # replaced as one: other threads read it

    def update(self, report: Report) -> None:
        """Take in a report; one that is no newer than the last is passed over."""
        last = self._reports[-1] if self._reports else None
        if not report.is_news(last):
            return
        goes_on = last is not None and 0.0 < report.stamp - last.stamp <= self._age
        kept = self._reports if goes_on else ()
        since = report.stamp - self._config.steady_time
        older = sum(each.stamp <= since for each in kept)  # the last of them covers the beginning
        self._reports = (*kept[max(0, older - 1) :], report)

    def taken(self, now: float) -> Report | Cause:
        """The place, where it is steady, or why it is not taken."""
        reports, config = self._reports, self._config
        if not reports:
            return Cause(Reason.TRACKER_STALE, "no place was tracked yet")
        newest = reports[-1]
        refusal = too_old(newest, now, self._age) or too_far(newest.place, self._home, config.range)
        if refusal is not None:
            return refusal
        places = np.array([report.place for report in reports])
        spread = float(np.linalg.norm(places - newest.place, axis=1).max())
        if not spread <= (allowed := config.steady_within):  # no number is not
            words = f"tracked place went {spread * 1e3:.1f} mm within {config.steady_time:.1f} s"
            return Cause(Reason.TRACKER_JUMPED, f"{words}, allowed {allowed * 1e3:.1f} mm")
        if any(is_other_way(report.pull, newest.pull) for report in reports):
            words = f"tracked way of the pull turned within {config.steady_time:.1f} s"
            allowed = float(np.degrees(SAME_WAY))
            return Cause(Reason.TRACKER_JUMPED, f"{words}, allowed {allowed:.0f} deg")
        since = newest.stamp - reports[0].stamp
        if since < config.steady_time - ROUNDING:
            words = f"place tracked for {since:.2f} s, allowed from {config.steady_time:.2f} s on"
            return Cause(Reason.TRACKER_STALE, words)
        return Report(places.mean(axis=0), newest.stamp, newest.pull)
