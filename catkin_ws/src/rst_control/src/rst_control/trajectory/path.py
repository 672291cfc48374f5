# SPDX-License-Identifier: BSD-3-Clause
"""A path q(s): cubic Hermite segments through solved knots with their true derivatives.

Only s moves while the robot does, so nothing done to the speed can take the shaft out of the
trocar. With knots h apart the polynomial is within h^4 / 384 times the largest fourth derivative
of the true q(s) (P. J. Davis, Interpolation and Approximation, 1963); planning measures it, too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rst_control.kernels import kernel
from rst_control.kinematics import forward as kin
from rst_control.kinematics.joint_limits import JointLimits
from rst_control.kinematics.rcm import rcm_offset
from rst_control.types import Vector

Array = NDArray[np.float64]
TINY = 1e-12


@kernel
def _hermite(knots: Any, slopes: Any, spacing: float, s: float, out: Any) -> None:
    last = len(knots) - 2
    k = min(max(int(s / spacing), 0), last)
    t, h = s / spacing - k, spacing
    a, b = 1.0 + t * t * (2.0 * t - 3.0), t * t * (3.0 - 2.0 * t)
    c, d = h * t * (t - 1.0) ** 2, h * t * t * (t - 1.0)
    a1 = 6.0 * t * (t - 1.0) / h
    c1, d1 = (t - 1.0) * (3.0 * t - 1.0), t * (3.0 * t - 2.0)
    a2 = (12.0 * t - 6.0) / (h * h)
    c2, d2 = (6.0 * t - 4.0) / h, (6.0 * t - 2.0) / h
    for j in range(9):
        p, q, m, n = knots[k, j], knots[k + 1, j], slopes[k, j], slopes[k + 1, j]
        out[0, j] = a * p + b * q + c * m + d * n
        out[1, j] = a1 * (p - q) + c1 * m + d1 * n
        out[2, j] = a2 * (p - q) + c2 * m + d2 * n


@kernel
def _evaluate(knots: Any, slopes: Any, spacing: float, s: float) -> Any:
    out = np.empty((3, 9))
    _hermite(knots, slopes, spacing, s, out)
    return out


@kernel
def _sample(
    chain: Any, knots: Any, slopes: Any, spacing: float, trocar: Any, s: Any, q: Any, seen: Any
) -> None:
    frames = np.empty((12, 3, 4))
    for n in range(len(s)):
        _hermite(knots, slopes, spacing, s[n], q[n])
        kin.forward(chain, q[n, 0], frames)
        x, y, along = rcm_offset(frames, trocar)
        seen[n, 0], seen[n, 1] = np.sqrt(x * x + y * y), along
        for i in range(3):
            seen[n, 2 + i] = frames[kin.TIP, i, 3]
            seen[n, 5 + i] = frames[kin.ELBOW, i, 3]


class PathPoint(NamedTuple):
    """Joints at one s, with their derivatives by s; each of shape (9,)."""

    q: Vector  # [rad]
    dq: Vector  # [rad/m]
    ddq: Vector  # [rad/m^2]


@dataclass(frozen=True, eq=False)
class Samples:
    """A path at many places, as evaluated through a trocar."""

    s: Vector  # (n,), [m]
    q: Array  # (n, 3, 9): joints, first and second derivative by s
    rcm_error: Vector  # (n,), [m]
    along: Vector  # (n,), [m] of shaft from interface_link to the trocar
    tip: Array  # (n, 3), base frame, [m]
    elbow: Array  # (n, 3), base frame, [m]: joint_4


class Path:
    """Joint motion along one number s, immutable.

    Args:
        knots: Joints at equal steps of s, [rad]. Shape (n, 9).
        slopes: Their derivatives by s, [rad/m]. Shape (n, 9).
        length: s at the last knot [m].
    """

    def __init__(self, knots: Array, slopes: Array, length: float) -> None:
        self.knots, self.slopes = _frozen(knots), _frozen(slopes)
        self.length = float(length)
        self.spacing = self.length / (len(knots) - 1)

    def evaluate(self, s: float) -> PathPoint:
        """Joints and derivatives at s [m], which is held within the path."""
        s = min(max(s, 0.0), self.length)
        return PathPoint(*_evaluate(self.knots, self.slopes, self.spacing, s))

    @property
    def start(self) -> Vector:
        """Joints at s = 0 [rad]. Shape (9,)."""
        return self.knots[0]

    @property
    def end(self) -> Vector:
        """Joints at s = length [rad]. Shape (9,)."""
        return self.knots[-1]

    def turned(self, turns: Vector) -> Path:
        """The same motion with joints further by whole turns (9,) [rad]."""
        return Path(self.knots + turns, self.slopes, self.length)

    def reversed(self) -> Path:
        """The same motion backwards."""
        return Path(self.knots[::-1], -self.slopes[::-1], self.length)

    def sample(self, chain: Array, trocar: Vector, per_knot: int = 10) -> Samples:
        """Evaluate the path at every knot and between, `per_knot` times as densely."""
        s = np.linspace(0.0, self.length, (len(self.knots) - 1) * per_knot + 1)
        q, seen = np.empty((len(s), 3, 9)), np.empty((len(s), 8))
        _sample(chain, self.knots, self.slopes, self.spacing, trocar, s, q, seen)
        return Samples(s, q, seen[:, 0], seen[:, 1], seen[:, 2:5], seen[:, 5:])


def speed_bounds(
    samples: Samples, limits: JointLimits, speed: float, acceleration: float
) -> tuple[float, float]:
    """Largest speed [m/s] and acceleration [m/s^2] of s that keep all joint limits on the path.

    Half of each joint's acceleration is kept for its path's own curvature at speed. Each place on
    the path is judged by itself.

    Args:
        samples: Of the path.
        limits: Joint limits.
        speed: Wanted [m/s], not exceeded.
        acceleration: Wanted [m/s^2], not exceeded.
    """
    rate, bend = np.abs(samples.q[:, 1]) + TINY, np.abs(samples.q[:, 2]) + TINY
    speed = min(speed, float((limits.velocity / rate).min()))
    speed = min(speed, float(np.sqrt(0.5 * limits.acceleration / bend).min()))
    spare = limits.acceleration - bend * speed * speed
    return speed, min(acceleration, float((spare / rate).min()))


def _frozen(values: Array) -> Array:
    array = np.array(values, dtype=np.float64, order="C")
    array.flags.writeable = False
    return array
