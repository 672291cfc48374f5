# SPDX-License-Identifier: BSD-3-Clause
"""Shapes that a viewer shows, as values: lines, balls, arrows, triangles, labels."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

Points = NDArray[np.float64]  # (n, 3), base frame, [m]
Colour = tuple[float, float, float, float]  # red, green, blue, opacity, each from 0 to 1

AXES = np.eye(3)


class ShapeKind(Enum):
    """What the points of a shape mean, and its size [m]."""

    LINE = "line"  # joined one after the other; width
    BALLS = "balls"  # centres; diameter
    ARROW = "arrow"  # tail and tip; width of the shaft
    TRIANGLES = "triangles"  # each three a triangle; no size
    LABEL = "label"  # middle of the text; height of its letters


@dataclass(frozen=True, eq=False)
class Shape:
    """Something to be seen."""

    name: str  # never changes; of each name a viewer shows what was sent last
    kind: ShapeKind
    points: Points
    size: float  # [m], see `ShapeKind`
    colour: Colour
    colours: NDArray[np.float32] | None = None  # (n, 4), of each point; None: all as `colour`
    text: str = ""  # of a label


def circle(centre: ArrayLike, radius: float, normal: ArrayLike, sides: int) -> Points:
    """A closed ring, its first point repeated at the end.

    Args:
        centre: Base frame, [m]. Shape (3,).
        radius: [m].
        normal: Direction square to the ring, of any length but zero. Shape (3,).
        sides: Number of straight pieces.

    Returns:
        Points, base frame, [m]. Shape (sides + 1, 3).
    """
    axis = np.array(normal, dtype=float)
    axis /= np.linalg.norm(axis)
    first = np.cross(axis, AXES[int(np.abs(axis).argmin())])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    angles = np.linspace(0.0, 2.0 * np.pi, sides + 1)[:, None]
    ring: Points = radius * (np.cos(angles) * first + np.sin(angles) * second)
    return ring + np.array(centre, dtype=float)
