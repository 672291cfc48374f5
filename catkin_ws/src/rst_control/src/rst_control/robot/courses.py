# SPDX-License-Identifier: BSD-3-Clause
"""Courses of the joints beside that of the set-points: beyond its end, into a stand, onto it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Joints = NDArray[np.float64]  # (10,), [rad] or [rad/s]


@dataclass(frozen=True, eq=False)
class Curve:
    """A course beyond its last known point: a parabola in joint space."""

    position: Joints
    velocity: Joints
    bend: Joints  # [rad/s^2] square to the velocity

    def at(self, time: float) -> tuple[Joints, Joints]:
        """Position [rad] and velocity [rad/s] at a time [s] from its start."""
        velocity = self.velocity + time * self.bend
        return self.position + 0.5 * time * (self.velocity + velocity), velocity


@dataclass(frozen=True, eq=False)
class Brake:
    """A curve on which time itself slows down to a stand, by the smooth step 3u^2 - 2u^3."""

    curve: Curve
    begun: float  # [s] time on the curve when braking starts
    start: float  # [s]
    duration: float  # [s]

    @classmethod
    def standing(cls, position: Joints) -> Brake:
        """At a position [rad], since ever."""
        still = np.zeros_like(position)
        return cls(Curve(np.array(position), still, still), 0.0, 0.0, 0.0)

    def at(self, now: float) -> tuple[Joints, Joints]:
        """Position [rad] and velocity [rad/s] at a time [s]."""
        if self.duration == 0.0:
            return self.curve.position, self.curve.velocity
        u = min(max((now - self.start) / self.duration, 0.0), 1.0)
        on_curve = self.begun + (u - u**3 + 0.5 * u**4) * self.duration
        position, velocity = self.curve.at(on_curve)
        return position, (1.0 - 3.0 * u**2 + 2.0 * u**3) * velocity


@dataclass(frozen=True, eq=False)
class Fade:
    """A distance from the course that vanishes, by the smooth step 3u^2 - 2u^3.

    The first set-point may lie a little away from where the joints hold: they get there slowly.
    """

    away: Joints  # [rad] at the start
    start: float  # [s]
    duration: float  # [s]

    @classmethod
    def over(cls, away: Joints, start: float, speed: Joints) -> Fade:
        """Of a distance, so slowly that no joint passes a speed [rad/s]."""
        return cls(away, start, float(np.max(1.5 * np.abs(away) / speed)))

    def at(self, now: float) -> tuple[Joints, Joints]:
        """What is left of the distance [rad] at a time [s], and how fast it changes [rad/s]."""
        u = (now - self.start) / self.duration if self.duration > 0.0 else 1.0
        u = min(max(u, 0.0), 1.0)
        rate = 0.0 if u == 1.0 else 6.0 * u * (1.0 - u) / self.duration
        return (1.0 - (3.0 - 2.0 * u) * u * u) * self.away, -rate * self.away

    def is_over(self, now: float) -> bool:
        """Whether nothing is left at a time [s]."""
        return now >= self.start + self.duration
