# SPDX-License-Identifier: BSD-3-Clause
"""What a stop came to, from its set-points: the same judge in process and in the running system."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from support.figures import Figure, percentiles

Array = NDArray[np.float64]
STILL = 1e-6  # [rad/s] norm of a set-point's velocities, below which the robot is sent nowhere
DRIFT = 1e-9  # [rad] by which a set-point may differ from the one before, at rest


@dataclass(frozen=True)
class SetpointCourse:
    """Set-points that were sent, in order."""

    stamps: Array  # (n,), [s] when each was due
    positions: Array  # (n, 10), [rad]
    velocities: Array  # (n, 10), [rad/s]

    @property
    def speeds(self) -> Array:
        """Norm of the velocities [rad/s]. Shape (n,)."""
        speeds: Array = np.linalg.norm(self.velocities, axis=1)
        return speeds


@dataclass(frozen=True)
class JudgedStop:
    """One message that asked for a stop, and what became of it."""

    situation: str  # when it came: in motion, braking after another stop, or at rest
    way: str  # how it came: in process, service, topic or cancel
    clients: int  # that sent one at the same moment
    latency: float | None  # [s] until the first decelerating set-point; None: nothing moved
    rest: float | None  # [s] until the set-points rested; None: nothing moved
    rcm_error: float  # [m] largest from the stop on
    objection: str  # why it counts as missed; empty: it was obeyed


def latency(course: SetpointCourse, received: float) -> float | None:
    """Time from a stop to the first set-point due after it that is slower than the one before [s].

    Returns:
        None where the robot was sent nowhere when it came; infinity where nothing slowed down.
    """
    speeds = course.speeds
    last = int(np.searchsorted(course.stamps, received, side="right")) - 1
    if last < 0 or speeds[last] <= STILL:
        return None
    slower = np.nonzero(speeds[last + 1 :] < speeds[last:-1])[0]
    return float(course.stamps[last + 1 + slower[0]] - received) if len(slower) else float("inf")


def rest(course: SetpointCourse, received: float) -> float | None:
    """Time from a stop until the set-points rest for good [s]; None where they rested before."""
    after = np.nonzero((course.stamps > received) & (course.speeds > STILL))[0]
    if not len(after):
        return None
    ended = int(after[-1]) + 1
    return float(course.stamps[ended] - received) if ended < len(course.stamps) else float("inf")


def objection(course: SetpointCourse, received: float, allowed: float) -> str:
    """Why a stop was not obeyed, by the set-points alone; empty: it was.

    Args:
        course: From before the stop until well after the robot rested.
        received: When it came [s].
        allowed: Time within which the set-points have to rest [s].
    """
    if not (course.stamps > received).any():
        return ""  # nothing is sent: the robot holds by itself
    late, ended = latency(course, received), rest(course, received)
    if late is not None and not np.isfinite(late):
        return "no set-point slowed down"
    if ended is not None and ended > allowed:
        return f"set-points moved for {ended * 1e3:.0f} ms, allowed {allowed * 1e3:.0f} ms"
    still = course.positions[course.stamps > received + max(allowed, ended or 0.0)]
    if len(still) < 2:
        return "not watched long enough after it"
    moved = float(np.abs(np.diff(still, axis=0)).max())
    return "" if moved <= DRIFT else f"set-points moved by {moved:.2g} rad after the rest"


def figures(name: str, stops: Sequence[JudgedStop], planned: int, period: float) -> list[Figure]:
    """Figures of a set of stops beside their targets.

    Args:
        name: What was measured, before each figure.
        stops: One or more.
        planned: How many there were to be.
        period: Between set-points [s].
    """
    missed = [stop for stop in stops if stop.objection]
    late = [s.latency * 1e3 for s in stops if s.latency is not None and np.isfinite(s.latency)]
    rests = [s.rest * 1e3 for s in stops if s.rest is not None and np.isfinite(s.rest)]
    whole = len(stops) >= planned
    found = [
        Figure(f"{name}: stops", len(stops), "", planned, at_most=False, note=_counts(stops)),
        Figure(f"{name}: missed", len(missed), "", 0.0 if whole else None, note=_first(missed)),
    ]
    if late:
        what = f"{name}: stop received to first decelerating set-point"
        ticks = f"(by the times for which set-points are due, every {period * 1e3:g} ms)"
        found += percentiles(what, late, "ms", {99: 4.0})
        found.append(Figure(f"{name}: stops in motion", len(late), "", note=ticks))
    if rests:
        found += percentiles(f"{name}: stop received to set-points at rest", rests, "ms")
    rcm = max((s.rcm_error for s in stops), default=0.0)
    return [*found, Figure(f"{name}: RCM error while stopping, max", rcm * 1e6, "um", 10.0)]


def _counts(stops: Sequence[JudgedStop]) -> str:
    many = sum(stop.clients > 1 for stop in stops)
    by = Counter(f"{stop.situation}" for stop in stops)
    ways = Counter(stop.way for stop in stops)
    parts = [f"{value} {key}" for key, value in (*sorted(ways.items()), *sorted(by.items()))]
    return f"({'; '.join(parts)}; {many} of many clients at once)"


def _first(missed: Sequence[JudgedStop]) -> str:
    if not missed:
        return ""
    return f"(the first: {missed[0].situation}, by {missed[0].way}: {missed[0].objection})"
