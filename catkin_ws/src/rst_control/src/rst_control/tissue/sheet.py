# SPDX-License-Identifier: BSD-3-Clause
"""A sheet of tissue at rest: where its nodes lie and which of them its surroundings hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rst_control.config import TissueConfig
from rst_control.types import Vector, unit_vector


def rest_points(config: TissueConfig) -> NDArray[np.float64]:
    """Places of the nodes at rest, base frame, [m]. Shape (columns * rows, 3)."""
    columns, rows = config.nodes
    along = unit_vector(config.along)
    across = np.cross(sheet_normal(config), along)
    u, w = np.meshgrid(
        (np.arange(columns) / (columns - 1) - 0.5) * config.size[0],
        (np.arange(rows) / (rows - 1) - 0.5) * config.size[1],
        indexing="ij",
    )
    flat = u.reshape(-1, 1) * along + w.reshape(-1, 1) * across
    points: NDArray[np.float64] = flat + np.array(config.centre)
    return points


def rim_nodes(config: TissueConfig) -> NDArray[np.bool_]:
    """Which nodes are fixed. Shape (columns * rows,)."""
    columns, rows = config.nodes
    column, row = np.divmod(np.arange(columns * rows), rows)
    sides = {
        "start": column == 0,
        "end": column == columns - 1,
        "left": row == rows - 1,
        "right": row == 0,
    }
    fixed: NDArray[np.bool_] = np.any([sides[name] for name in config.rim], axis=0)
    return fixed


def free_sides(config: TissueConfig) -> tuple[tuple[Vector, Vector], ...]:
    """Sides that nothing holds: a point of each [m] and its unit normal out of the sheet.

    Returns:
        Pairs of arrays of shape (3,), base frame.
    """
    along = unit_vector(config.along)
    across = np.cross(sheet_normal(config), along)
    half = 0.5 * np.array(config.size)
    sides = {
        "start": -half[0] * along,
        "end": half[0] * along,
        "left": half[1] * across,
        "right": -half[1] * across,
    }
    free = [way for name, way in sides.items() if name not in config.rim]
    return tuple((config.centre + way, unit_vector(way)) for way in free)


def sheet_normal(config: TissueConfig) -> NDArray[np.float64]:
    """Unit normal of the sheet, base frame. Shape (3,)."""
    return unit_vector(np.cross(config.along, config.across))
