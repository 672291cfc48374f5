# SPDX-License-Identifier: BSD-3-Clause
"""What becomes of a goal's points: way-points with durations, and the course through them.

Durations follow ros_kortex: velocities and accelerations of a point are dropped, the first
way-point lasts a fixed time whatever the goal says, and very short ones are lengthened. How the
firmware joins way-points is not published; here each joint takes the cubic through them that never
turns back between two of them and is at rest at both ends (Fritsch and Butland's). Between points
close to each other that makes little difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rst_control.types import Vector

SAMPLES = 5  # within each stretch between two way-points, to find its greatest speed


@dataclass(frozen=True, eq=False)
class Point:
    """One point of a goal, as far as the driver uses it."""

    positions: tuple[float, ...]  # [rad]
    time: float  # [s] from the start


@dataclass(frozen=True, eq=False)
class Waypoint:
    """One way-point as the arm gets it."""

    angles: tuple[float, ...]  # [rad]
    duration: float  # [s] from the one before


@dataclass(frozen=True, eq=False)
class ArmLimits:
    """What the arm keeps; each of shape (7,)."""

    lower: Vector  # [rad]
    upper: Vector  # [rad]
    speed: Vector  # [rad/s]
    acceleration: Vector  # [rad/s^2]
    braking: Vector  # [rad/s^2] at an emergency stop


def make_waypoints(
    points: Sequence[Point], first_duration: float, min_duration: float
) -> list[Waypoint]:
    """Way-points of a goal's points.

    Args:
        points: In their order.
        first_duration: Of the first way-point [s].
        min_duration: Of any other [s].
    """
    durations = [first_duration]
    for before, after in pairwise(points):
        durations.append(max(after.time - before.time, min_duration))
    return [
        Waypoint(point.positions, duration)
        for point, duration in zip(points, durations, strict=False)
    ]


class Course:
    """Where the joints are at a time after the start.

    Args:
        start: Joints at the start [rad]. Shape (7,).
        waypoints: At least one, each of finite angles.
    """

    def __init__(self, start: Vector, waypoints: Sequence[Waypoint]) -> None:
        self._times = np.concatenate([[0.0], np.cumsum([w.duration for w in waypoints])])
        knots = np.vstack([start, [w.angles for w in waypoints]])  # (n + 1, 7)
        slopes = np.zeros_like(knots)
        if len(waypoints) > 1:
            slopes[1:-1] = monotone_slopes(self._times, knots)
        self._knots, self._slopes, self._end = knots, slopes, knots[-1]

    @property
    def duration(self) -> float:
        """Of the whole [s]."""
        return float(self._times[-1])

    def at(self, time: float) -> tuple[Vector, Vector]:
        """Position [rad] and velocity [rad/s] at a time from the start [s]; shapes (7,)."""
        if time >= self.duration:
            return self._end, np.zeros_like(self._end)
        position, velocity = self._through(np.array([time]))
        return position[0], velocity[0]

    def max_joint_speed(self) -> Vector:
        """Of each joint [rad/s]; shape (7,)."""
        steps = np.diff(self._times)[:, None] * np.linspace(0.0, 1.0, SAMPLES, endpoint=False)
        times = (self._times[:-1, None] + steps).ravel()
        return np.abs(self._through(times)[1]).max(axis=0)

    def _through(self, times: Vector) -> tuple[Vector, Vector]:
        """Positions and velocities at times (n,) by cubic Hermite segments; shapes (n, 7)."""
        at = np.clip(np.searchsorted(self._times, times, "right") - 1, 0, len(self._times) - 2)
        span = np.diff(self._times)[at, None]
        u = (times - self._times[at])[:, None] / span
        rise = self._knots[at + 1] - self._knots[at]
        first, last = span * self._slopes[at], span * self._slopes[at + 1]
        bend, twist = 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise
        position = self._knots[at] + u * (first + u * (bend + u * twist))
        return position, (first + u * (2.0 * bend + 3.0 * u * twist)) / span

    def max_joint_acceleration(self) -> Vector:
        """Of each joint, as its mean speeds between way-points change [rad/s^2]; shape (7,)."""
        spans = np.diff(self._times)[:, None]
        means = np.diff(self._knots, axis=0) / spans  # (n, 7)
        change = np.diff(means, axis=0, append=np.zeros_like(means[:1]))  # at rest after the end
        apart = 0.5 * (spans + np.append(spans[1:], np.zeros((1, 1)), axis=0))
        return np.abs(change / apart).max(axis=0)


def monotone_slopes(times: Vector, knots: Vector) -> Vector:
    """Slopes at the inner knots, with which no cubic turns back between two of them.

    The weighted harmonic mean of both sides, or zero where they differ in sign (Fritsch and
    Butland, SIAM J. Sci. Stat. Comput. 5, 1984).

    Args:
        times: Rising. Shape (n,).
        knots: Shape (n, joints).

    Returns:
        Shape (n - 2, joints).
    """
    spans = np.diff(times)[:, None]
    sides = np.diff(knots, axis=0) / spans
    before, after = sides[:-1], sides[1:]
    near, far = 2.0 * spans[1:] + spans[:-1], spans[1:] + 2.0 * spans[:-1]
    is_one_way = before * after > 0.0
    weighted = near / np.where(is_one_way, before, 1.0) + far / np.where(is_one_way, after, 1.0)
    return np.where(is_one_way, (near + far) / weighted, 0.0)


def objections(start: Vector, waypoints: Sequence[Waypoint], limits: ArmLimits) -> list[str]:
    """Why the arm would not run way-points from where it stands; empty: it would.

    Args:
        start: Joints now [rad]. Shape (7,).
        waypoints: As sent.
        limits: Position, speed and acceleration.
    """
    if not waypoints:
        return ["a trajectory without way-points"]
    joints = len(start)
    for number, waypoint in enumerate(waypoints):
        if len(waypoint.angles) != joints:
            return [f"way-point {number} has {len(waypoint.angles)} angles, allowed: {joints}"]
        if not np.isfinite(waypoint.angles).all():
            return [f"way-point {number} has an angle that is not a finite number"]
    course, angles = Course(start, waypoints), np.array([w.angles for w in waypoints])
    lowest, highest = angles.min(axis=0), angles.max(axis=0)
    found = []
    for joint in range(joints):
        low, high = limits.lower[joint], limits.upper[joint]
        if lowest[joint] < low or highest[joint] > high:
            found.append(
                f"actuator {joint + 1} would go from {lowest[joint]:.4f} to {highest[joint]:.4f} "
                f"rad, allowed {low:.4f} to {high:.4f}"
            )
    speed, acceleration = course.max_joint_speed(), course.max_joint_acceleration()
    found += _above("rad/s", speed, limits.speed)
    return found + _above("rad/s^2", acceleration, limits.acceleration)


def _above(unit: str, values: Vector, allowed: Vector) -> list[str]:
    return [
        f"actuator {joint + 1} would need {values[joint]:.4f} {unit}, allowed {allowed[joint]:.4f}"
        for joint in np.flatnonzero(values > allowed)
    ]
