# SPDX-License-Identifier: BSD-3-Clause
"""Pivot calibration: the point that many poses of the shaft have in common is the trocar.

The shaft slides through the trocar, so each pose gives a line and not a place on it. The wanted
point p has the least sum of squared distances from the lines a_i + t d_i:

    p = A^-1 b,   A = sum P_i,   b = sum P_i a_i,   P_i = 1 - d_i d_i^T

(L. Han and J. C. Bancroft, "Nearest approaches to multiple lines in n-dimensional space", CREWES
Research Report 22, 2010). Each line gives two equations, so the variance of a distance along one
axis is s^2 = sum r_i^2 / (2n - 3), and the covariance of p is s^2 A^-1. How much to trust such a
calibration: Z. Yaniv, "Which pivot calibration?", Proc. SPIE 9415, 2015.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rst_control.errors import RstError
from rst_control.types import Vector, frozen_array

Array = NDArray[np.float64]

FEWEST: Final = 2  # lines that can have one point in common
PARALLEL: Final = 1e-6  # [rad] spread below which rounding decides where the point is
OUTLYING: Final = 4.0  # standard deviations; by chance 3 of 10,000 lines are further away
FLOOR: Final = 1e-5  # [m] distances below it are never outlying: encoders resolve no more
ROBUST_STEPS: Final = 30
MEDIAN: Final = float(np.sqrt(2.0 * np.log(2.0)))  # of the Rayleigh distribution, in deviations


class PivotIllPosed(RstError):
    """The recorded poses do not determine a point."""


class TooFewPoses(PivotIllPosed):
    """There are fewer poses than asked for."""

    def __init__(self, count: int, least: int) -> None:
        super().__init__(f"{count} shaft poses recorded, allowed {least} and more")
        self.count, self.least = count, least


class TooLittleSpread(PivotIllPosed):
    """The shaft pointed nearly the same way in every pose."""

    def __init__(self, spread: float, least: float) -> None:
        super().__init__(
            f"shaft directions spread by {np.degrees(spread):.2f} deg rms, "
            f"allowed {np.degrees(least):.2f} deg and more: tilt the shaft further"
        )
        self.spread, self.least = spread, least


@dataclass(frozen=True, eq=False)
class PivotFit:
    """The point nearest to all shafts, and how well they agree on it."""

    position: Vector  # (3,), base frame, [m]
    residuals: Vector  # (n,), [m] of each shaft line from the point
    covariance: Array  # (3, 3), [m^2], base frame
    spread: float  # [rad] rms angle of the shafts from their common direction
    outliers: tuple[int, ...]  # numbers of poses, from 0, that contradict the others

    @property
    def rms(self) -> float:
        """Root of the mean squared residual [m]."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def largest(self) -> float:
        """Largest residual [m]."""
        return float(self.residuals.max())

    @property
    def deviation(self) -> float:
        """Standard deviation of the point along the direction in which it is known worst [m]."""
        return float(np.sqrt(max(np.linalg.eigvalsh(self.covariance)[-1], 0.0)))


def fit_pivot(
    points: ArrayLike, directions: ArrayLike, min_poses: int, min_spread: float
) -> PivotFit:
    """Find the point that shaft lines have in common.

    Args:
        points: One point of each line, base frame, [m]. Shape (n, 3).
        directions: Directions of the lines, of any length but zero. Shape (n, 3).
        min_poses: Fewest lines that are accepted; never fewer than two.
        min_spread: Least rms angle between the lines and their common direction [rad].

    Raises:
        TooFewPoses: There are fewer lines.
        TooLittleSpread: They are nearly parallel.
        ValueError: A value is not finite, a direction is zero, or the shapes differ.
    """
    count = len(np.asarray(points))
    if count < max(min_poses, FEWEST):
        raise TooFewPoses(count, max(min_poses, FEWEST))
    a, P = frozen_array(points, count, 3), _projections(frozen_array(directions, count, 3))
    spread = _spread(P)
    if spread < max(min_spread, PARALLEL):
        raise TooLittleSpread(spread, max(min_spread, PARALLEL))
    centre = a.mean(axis=0)  # near the answer, where rounding does least
    offsets, equal = a - centre, np.ones(count)
    p = _nearest(P, offsets, equal)
    residuals = _distances(P, offsets, p)
    return PivotFit(
        position=frozen_array(centre + p, 3),
        residuals=frozen_array(residuals, count),
        covariance=frozen_array(_variance(residuals) * np.linalg.inv(P.sum(axis=0)), 3, 3),
        spread=spread,
        outliers=_outliers(P, offsets, p),
    )


def _projections(directions: Vector) -> Array:
    """Matrices (n, 3, 3) that take the part square to each direction."""
    length = np.linalg.norm(directions, axis=1)
    if not length.all():
        raise ValueError(f"direction {int(length.argmin())} has no length, allowed: above zero")
    d = directions / length[:, None]
    P: Array = np.eye(3) - d[:, :, None] * d[:, None, :]
    return P


def _spread(P: Array) -> float:
    """Rms angle of the lines from the direction they come nearest to [rad].

    The least eigenvalue of A / n is the mean squared sine of that angle.
    """
    least = float(np.linalg.eigvalsh(P.mean(axis=0))[0])
    return float(np.arcsin(np.sqrt(min(max(least, 0.0), 1.0))))


def _nearest(P: Array, points: Array, weights: Vector) -> Vector:
    A = np.einsum("n,nij->ij", weights, P)
    b = np.einsum("n,nij,nj->i", weights, P, points)
    p: Vector = np.linalg.lstsq(A, b, rcond=None)[0]
    return p


def _distances(P: Array, points: Array, p: Vector) -> Vector:
    distances: Vector = np.linalg.norm(np.einsum("nij,nj->ni", P, p - points), axis=1)
    return distances


def _variance(distances: Vector) -> float:
    """Of a distance along one axis [m^2]: two equations a line, less three unknowns."""
    return float(distances @ distances) / (2 * len(distances) - 3)


def _outliers(P: Array, points: Array, start: Vector) -> tuple[int, ...]:
    """Lines far from where the others meet, which a few bad ones cannot hide by dragging the fit.

    A first point has the least sum of distances (least squares with weights of one over the
    distance, E. Weiszfeld, 1937). Lines far from it are left out of a second fit by plain least
    squares, which judges all (P. J. Rousseeuw and A. M. Leroy, "Robust regression and outlier
    detection", 1987, with their correction of the median for few data).
    """
    p, count = start, len(points)
    for _ in range(ROBUST_STEPS):
        p = _nearest(P, points, 1.0 / np.maximum(_distances(P, points, p), 0.1 * FLOOR))
    distances = _distances(P, points, p)
    deviation = float(np.median(distances)) / MEDIAN * (1.0 + 5.0 / (2 * count - 3))
    good = distances <= max(OUTLYING * deviation, FLOOR)
    distances = _distances(P, points, _nearest(P, points, good.astype(np.float64)))
    allowed = max(OUTLYING * np.sqrt(_variance(distances[good])), FLOOR)
    return tuple(int(n) for n in np.flatnonzero(distances > allowed))
