# SPDX-License-Identifier: BSD-3-Clause
"""What a viewer shows of the tissue: the sheet, its fixed rim, the place where the jaws hold it."""

from __future__ import annotations

import numpy as np

from rst_control.config import TissueConfig
from rst_control.simulation.rendering.sheet_mesh import (
    SheetStretch,
    grid_faces,
    strain_colours,
    strain_share,
)
from rst_control.tissue.sheet import rest_points, rim_nodes
from rst_control.visualization.shapes import Colour, Points, Shape, ShapeKind

RIM: Colour = (0.20, 0.22, 0.26, 1.0)
HELD: Colour = (0.94, 0.89, 0.26, 1.0)
SHEET: Colour = (1.0, 1.0, 1.0, 1.0)
BALL = 0.004  # [m] diameter of a node


class TissueShapes:
    """Makes the shapes of one moment.

    Args:
        config: The sheet.
    """

    def __init__(self, config: TissueConfig) -> None:
        rest = rest_points(config)
        self._faces = grid_faces(*config.nodes)
        self._stretch, self._rim = SheetStretch(rest, self._faces), rim_nodes(config)

    def __call__(self, nodes: Points, held: int) -> list[Shape]:
        """Shapes of the sheet; the more it is stretched the darker it is.

        Args:
            nodes: Base frame, [m]. Shape (columns * rows, 3).
            held: Number of the node that the jaws hold; -1: none.
        """
        corners = self._faces.ravel()
        stretch = self._stretch.at_points(self._stretch.of_faces(nodes))
        colours = np.ones((len(nodes), 4), np.float32)
        colours[:, :3] = strain_colours(strain_share(stretch))
        shapes = [
            Shape("tissue", ShapeKind.TRIANGLES, nodes[corners], 0.0, SHEET, colours[corners]),
            Shape("tissue rim", ShapeKind.BALLS, nodes[self._rim], BALL, RIM),
        ]
        if held >= 0:
            shapes.append(Shape("tissue held", ShapeKind.BALLS, nodes[[held]], 1.5 * BALL, HELD))
        return shapes
