# SPDX-License-Identifier: BSD-3-Clause
"""From a click into the endoscope's picture to a point of the tissue."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ASIDE = 0.006  # [m] from the click to a node of the sheet, at most
FLAT = 0.05  # cosine of the ray to the sheet's normal, from which the hit is sharp enough


class NotOnTissueError(ValueError):
    """A click means no point of the tissue; says why."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera, in pixels of the whole picture.

    Attributes:
        matrix: Intrinsic. Shape (3, 3).
        pose: Of the optical frame in the base frame: x right, y down, z forward. Shape (4, 4).
        size: Width and height of the picture [pixels].
        region: Left, top, right and bottom of what this camera sees [pixels].
    """

    matrix: Array
    pose: Array
    size: tuple[int, int]
    region: tuple[int, int, int, int]

    def ray(self, x: float, y: float) -> tuple[Array, Array]:
        """Where the ray of a pixel begins [m], and its unit direction; base frame.

        Args:
            x: From the left edge of the whole picture, as a share of its width.
            y: From its top, as a share of its height.

        Raises:
            NotOnTissueError: This camera does not see there.
        """
        u, v = x * self.size[0], y * self.size[1]
        left, top, right, bottom = self.region
        if not (left <= u < right and top <= v < bottom):
            raise NotOnTissueError("that is outside the endoscope's picture")
        way = self.pose[:3, :3] @ np.linalg.solve(self.matrix, [u, v, 1.0])
        return self.pose[:3, 3], way / np.linalg.norm(way)


@dataclass(frozen=True, eq=False)
class Sheet:
    """The tissue at rest.

    Attributes:
        nodes: Base frame [m]. Shape (n, 3).
        normal: Unit vector. Shape (3,).
    """

    nodes: Array
    normal: Array

    def nearest(self, camera: Camera, x: float, y: float) -> Array:
        """The node that is nearest to where the ray of a click meets the sheet [m]. Shape (3,).

        Args:
            camera: That took the picture.
            x: Share of the picture's width.
            y: Share of its height.

        Raises:
            NotOnTissueError: The ray passes the sheet.
        """
        origin, way = camera.ray(x, y)
        slope = float(way @ self.normal)
        if abs(slope) < FLAT:
            raise NotOnTissueError("the endoscope sees the tissue from its edge there")
        depth = float((self.nodes[0] - origin) @ self.normal) / slope
        aside = np.linalg.norm(self.nodes - (origin + depth * way), axis=1)
        if depth <= 0.0 or aside.min() > ASIDE:
            raise NotOnTissueError("there is no tissue")
        found: Array = self.nodes[int(aside.argmin())]
        return found
