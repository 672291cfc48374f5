# SPDX-License-Identifier: BSD-3-Clause
"""Where a tracked trocar is, between its reports and a little ahead."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from rst_control.config.tracking import TrackingConfig
from rst_control.registration.tracked_place import Report, too_far, too_old
from rst_control.types import Cause, Reason, Vector

NEVER: Final = Cause(Reason.TRACKER_STALE, "no trocar was tracked yet")


@dataclass(frozen=True, eq=False)
class _Course:
    """Where the trocar was at a time, and how it goes."""

    stamp: float  # [s]; minus infinity: no report yet
    place: Vector  # [m], base frame, shape (3,)
    velocity: Vector  # [m/s], shape (3,)


class TrackedTrocar:
    """Smooths and judges the reports of a trocar.

    Its place and velocity follow the reports by an alpha-beta filter with the gains of Benedict and
    Bordner (1962): beta = alpha^2 / (2 - alpha). One report that is not believed is an objection
    until reports have been good again for `age`.

    Args:
        config: What is believed.
        home: The trocar of the scene, base frame, [m]. Shape (3,).
    """

    def __init__(self, config: TrackingConfig, home: Vector) -> None:
        self._config, self._home = config, np.array(home)
        self._last: Report | None = None  # taken in, good or not
        self._course = _Course(-math.inf, np.array(home), np.zeros(3))  # replaced as a whole
        self._bad: Cause | None = None
        self._good_since = -math.inf

    def update(self, report: Report) -> None:
        """Take in a report; one that is no newer than the last is passed over."""
        config, last = self._config.trocar, self._last
        if not report.is_news(last):
            return
        if last is not None and report.stamp <= last.stamp:
            last = None
        bad = too_far(report.place, self._home, config.range)
        span = math.inf if last is None else report.stamp - last.stamp
        if last is not None and span <= self._config.age:
            bad = bad or self._jump(report, last, span)
        if bad is not None:
            self._bad, self._good_since, self._last = bad, math.inf, report
            return
        if self._good_since == math.inf:
            self._good_since = report.stamp
        if last is None or span > self._config.age or self._bad is not None:
            self._course = _Course(report.stamp, np.array(report.place), np.zeros(3))
        else:
            self._course = self._smoothed(report, span)
        self._last = report
        if report.stamp - self._good_since >= self._config.age:
            self._bad = None

    def objection(self, now: float) -> Cause | None:
        """Why the trocar's place is not known at a time [s]; None: it is."""
        if self._last is None:
            return NEVER
        return self._bad or too_old(self._last, now, self._config.age)

    def shift(self, now: float) -> tuple[Vector, Vector]:
        """How far it is from home [m], and how fast it goes [m/s], at a time. Shapes (3,)."""
        course = self._course  # reports come in another thread
        ahead = min(now - course.stamp, 2.0 * self._config.age)
        return course.place + ahead * course.velocity - self._home, course.velocity

    def _jump(self, report: Report, last: Report, span: float) -> Cause | None:
        way = float(np.linalg.norm(report.place - last.place))
        allowed = self._config.trocar.jump + self._config.trocar.max_speed * span
        if way <= allowed:
            return None
        words = f"tracked trocar jumped by {way * 1e3:.1f} mm in {span * 1e3:.0f} ms"
        return Cause(Reason.TRACKER_JUMPED, f"{words}, allowed {allowed * 1e3:.1f} mm")

    def _smoothed(self, report: Report, span: float) -> _Course:
        alpha = 1.0 - math.exp(-span / self._config.trocar.filter_time)
        beta = alpha * alpha / (2.0 - alpha)
        predicted = self._course.place + span * self._course.velocity
        miss = report.place - predicted
        velocity = self._course.velocity + (beta / span) * miss
        return _Course(report.stamp, predicted + alpha * miss, velocity)
