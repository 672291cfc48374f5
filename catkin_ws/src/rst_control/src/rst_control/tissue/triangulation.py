# SPDX-License-Identifier: BSD-3-Clause
"""When tissue counts as triangulated: held between two fixed points and the grasp, flat and taut.

A sheet is well exposed where the jaws hold it at the point meant, the triangle of the grasp and two
points of the fixed rim is not a sliver, the sheet within that triangle is flat, and the pull is
strong enough to expose and too weak to harm.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from rst_control.config import TriangulationConfig
from rst_control.types import Vector, unit_vector

Points = NDArray[np.float64]  # (n, 3), base frame, [m]


@dataclass(frozen=True, eq=False)
class Triangulation:
    """A sheet as it is held."""

    grasp_error: float  # [m]
    min_angle: float  # [rad]
    out_of_plane: float  # [m] rms of the nodes within the triangle, from its plane
    tension: float  # [N]
    strain: float  # [-]

    def failures(self, limits: TriangulationConfig) -> tuple[str, ...]:
        """What is not as it should be, each with its value and what was allowed; NaN never is."""
        low, high = limits.tension
        checks = (
            _above("grasp error", self.grasp_error * 1e3, limits.grasp_error * 1e3, "mm"),
            _below("angle", np.degrees(self.min_angle), np.degrees(limits.min_angle), "deg"),
            _above("out of plane", self.out_of_plane * 1e3, limits.out_of_plane * 1e3, "mm"),
            _below("tension", self.tension, low, "N"),
            _above("tension", self.tension, high, "N"),
            _above("strain", self.strain, limits.strain, ""),
        )
        return tuple(words for words in checks if words)


def triangulation(
    nodes: Points,
    rim: NDArray[np.bool_],
    jaws: Vector,
    missed: Vector,
    tension: float,
    strain: float,
) -> Triangulation:
    """Judge a sheet.

    Args:
        nodes: Of the sheet, base frame, [m]. Shape (n, 3).
        rim: Which of them are fixed. Shape (n,).
        jaws: Where they hold the sheet now, base frame, [m]. Shape (3,).
        missed: From where the jaws closed to the point meant [m]. Shape (3,).
        tension: Of the sheet on the jaws [N].
        strain: Largest of the sheet [-].

    Raises:
        ValueError: The rim has fewer than two nodes.
    """
    a, b = best_anchors(nodes[rim], jaws)
    return Triangulation(
        grasp_error=float(np.linalg.norm(missed)),
        min_angle=float(triangle_angles(a, b, jaws).min()),
        out_of_plane=out_of_plane(nodes, a, b, jaws),
        tension=tension,
        strain=strain,
    )


def triangle_angles(a: Vector, b: Vector, c: Vector) -> Vector:
    """Angles at three corners (3,), base frame, [m]; in [rad], shape (3,)."""
    corners = np.array([a, b, c])
    ahead = np.roll(corners, -1, axis=0) - corners
    back = np.roll(corners, 1, axis=0) - corners
    sine = np.linalg.norm(np.cross(ahead, back), axis=1)
    angles: Vector = np.arctan2(sine, (ahead * back).sum(axis=1))
    return angles


def best_anchors(rim: Points, jaws: Vector) -> Points:
    """The two points of the rim whose triangle with the jaws has the largest least angle.

    Args:
        rim: Fixed points, base frame, [m]. Shape (n, 3).
        jaws: Base frame, [m]. Shape (3,).

    Returns:
        Shape (2, 3).

    Raises:
        ValueError: There are fewer than two.
    """
    if len(rim) < 2:
        raise ValueError(f"rim of {len(rim)} fixed points, allowed: 2 and more")
    pairs = np.array(list(combinations(range(len(rim)), 2)))
    a, b = rim[pairs[:, 0]], rim[pairs[:, 1]]
    sides = np.array(
        [np.linalg.norm(x, axis=1) for x in (b - a, jaws - b, a - jaws)]
    )  # (3, pairs), opposite to jaws, a, b
    x, y, z = np.sort(sides, axis=0) + 1e-12  # the least angle lies opposite to the shortest side
    cosine = (y * y + z * z - x * x) / (2.0 * y * z)
    return rim[pairs[int(cosine.argmin())]]


def out_of_plane(nodes: Points, a: Vector, b: Vector, c: Vector) -> float:
    """Root mean square distance from a triangle's plane of the nodes that lie within it [m].

    Args:
        nodes: Base frame, [m]. Shape (n, 3).
        a: Corner, base frame, [m]. Shape (3,).
        b: Corner.
        c: Corner.
    """
    basis = np.array([b - a, c - a])  # (2, 3)
    normal = np.cross(basis[0], basis[1])
    normal = normal / max(float(np.linalg.norm(normal)), 1e-12)
    share = np.linalg.lstsq(basis.T, (nodes - a).T, rcond=None)[0]  # (2, n)
    inside = (share.min(axis=0) >= -1e-6) & (share.sum(axis=0) <= 1.0 + 1e-6)
    height = (nodes[inside] - a) @ normal
    return float(np.sqrt(np.mean(height**2))) if len(height) else 0.0


def pull_direction(rim: Points, grasp: Vector) -> Vector:
    """Way to pull so that a sheet is taut in its triangle: from between its anchors to the grasp.

    Args:
        rim: Fixed points, base frame, [m]. Shape (n, 3).
        grasp: Base frame, [m]. Shape (3,).

    Returns:
        Unit vector, base frame. Shape (3,).
    """
    return unit_vector(grasp - best_anchors(rim, grasp).mean(axis=0))


def _above(name: str, value: float, most: float, unit: str) -> str:
    words = f"{name} {value:.3g} {unit}".rstrip()
    return f"{words}, at most {most:.3g}" if not value <= most else ""


def _below(name: str, value: float, least: float, unit: str) -> str:
    words = f"{name} {value:.3g} {unit}".rstrip()
    return f"{words}, at least {least:.3g}" if not value >= least else ""
