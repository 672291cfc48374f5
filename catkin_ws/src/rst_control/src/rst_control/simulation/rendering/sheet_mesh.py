# SPDX-License-Identifier: BSD-3-Clause
"""Grids of points as triangles: their edges, normals, stretch and its colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]  # (n, 3), [m]
Faces = NDArray[np.int64]  # (m, 3), numbers of points

RELAXED, TAUT = np.array([0.93, 0.55, 0.52]), np.array([0.70, 0.06, 0.10])  # red, green, blue
TAUT_STRAIN = 0.4  # [-] stretched by this much: darkest


def grid_faces(columns: int, rows: int, closed: bool = False) -> Faces:
    """Triangles of a grid, node (column, row) at column * rows + row; closed joins the ends."""
    column = np.arange(columns - 1)[:, None] * rows
    row = np.arange(rows if closed else rows - 1)[None, :]
    after = (row + 1) % rows
    a, b = (column + row).ravel(), (column + rows + row).ravel()
    c, d = (column + rows + after).ravel(), (column + after).ravel()
    return np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def edge_lengths(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Lengths of the sides of each triangle [m]. Shape (m, 3)."""
    corners = points[faces]  # (m, 3, 3)
    sides = corners - corners[:, [2, 0, 1]]
    lengths: NDArray[np.float64] = np.sqrt(np.einsum("mij,mij->mi", sides, sides))
    return lengths


def node_normals(points: Points, faces: Faces) -> Points:
    """Unit normals of the points, the mean of their triangles'. Shape (n, 3)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    normals = np.zeros_like(points)
    for k in range(3):
        np.add.at(normals, faces[:, k], np.cross(b - a, c - a))
    unit: Points = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return unit


class SheetStretch:
    """How much a sheet is stretched, by its triangles.

    Args:
        rest: Points of the sheet at rest [m]. Shape (n, 3).
        faces: Its triangles. Shape (m, 3).
    """

    def __init__(self, rest: Points, faces: Faces) -> None:
        self._faces, self._corners = faces, faces.ravel()
        self._lengths = edge_lengths(rest, faces)
        self._uses = np.bincount(self._corners)

    def of_faces(self, points: Points) -> NDArray[np.float64]:
        """Largest stretch of a side of each triangle [-]. Shape (m,)."""
        stretch: NDArray[np.float64] = (edge_lengths(points, self._faces) / self._lengths).max(
            axis=1
        ) - 1.0
        return stretch

    def at_points(self, of_faces: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean over the triangles around each point. Shape (n,)."""
        mean: NDArray[np.float64] = np.bincount(self._corners, np.repeat(of_faces, 3)) / self._uses
        return mean


def strain_share(stretch: NDArray[np.float64]) -> NDArray[np.float64]:
    """From 0, relaxed, to 1, as taut as colours show."""
    share: NDArray[np.float64] = np.clip(stretch / TAUT_STRAIN, 0.0, 1.0)
    return share


def strain_colours(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Red, green and blue for shares between relaxed and taut. Shape (n, 3)."""
    colours: NDArray[np.float64] = RELAXED + share[:, None] * (TAUT - RELAXED)
    return colours
