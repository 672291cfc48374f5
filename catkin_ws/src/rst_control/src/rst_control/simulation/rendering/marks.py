# SPDX-License-Identifier: BSD-3-Clause
"""What a picture shows that no camera sees: the way of the tip, and the pull as an arrow."""

from __future__ import annotations

import numpy as np
import pybullet

from rst_control.simulation.rendering.sheet_mesh import Points, grid_faces
from rst_control.visualization.shapes import circle

WAY, ARROW = (0.00, 0.45, 0.90, 1.0), (0.00, 0.70, 0.30, 1.0)  # red, green, blue, opacity
WAY_RADIUS = 0.0006  # [m]
ARROW_SCALE = 0.02  # [m/N]
SHAFT_RADIUS, HEAD_RADIUS, HEAD_LENGTH = 0.0020, 0.0042, 0.0090  # [m]
MIN_FORCE = 0.05  # [N] below which there is no arrow
MIN_STEP = 1e-6  # [m] between points of a way
SIDES = 12


class SceneMarks:
    """Bodies without mass in a PyBullet world, drawn again for each picture.

    Args:
        client: The world.
    """

    def __init__(self, client: int) -> None:
        self._on = {"physicsClientId": client}
        self._bodies: list[int] = []

    def show(self, trail: Points, tip: Points, force: Points) -> None:
        """Draw the way of the tip and the force at its end.

        Args:
            trail: Where the tip was, base frame, [m]. Shape (n, 3).
            tip: Where it is, base frame, [m]. Shape (3,).
            force: Of the tissue on the jaws, base frame, [N]. Shape (3,).
        """
        for body in self._bodies:
            pybullet.removeBody(body, **self._on)
        self._bodies = []
        if len(trail) > 1:
            self._add(trail, np.full(len(trail), WAY_RADIUS), WAY)
        strength = float(np.linalg.norm(force))
        if strength >= MIN_FORCE:
            along, length = force / strength, ARROW_SCALE * strength
            reach = np.array([0.0, length, length, length + HEAD_LENGTH])
            radii = np.array([SHAFT_RADIUS, SHAFT_RADIUS, HEAD_RADIUS, 0.0])
            self._add(tip + reach[:, None] * along, radii, ARROW)

    def _add(self, points: Points, radii: Points, colour: tuple[float, ...]) -> None:
        vertices, normals = tube(points, radii)
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=vertices.tolist(),
            indices=grid_faces(len(points), SIDES, closed=True)[:, ::-1].ravel().tolist(),
            normals=normals.tolist(),
            rgbaColor=colour,
            specularColor=[0, 0, 0],
            **self._on,
        )
        self._bodies.append(
            pybullet.createMultiBody(baseMass=0.0, baseVisualShapeIndex=shape, **self._on)
        )


def tube(points: Points, radii: Points) -> tuple[Points, Points]:
    """Rings about the points of a line, square to it.

    Args:
        points: [m]. Shape (n, 3).
        radii: Of the rings [m]. Shape (n,).

    Returns:
        Vertices and their normals, ring after ring. Shapes (n * SIDES, 3).
    """
    along = np.gradient(points, axis=0)
    along[np.linalg.norm(along, axis=1) < MIN_STEP] = (0.0, 0.0, 1.0)  # turns back on itself
    normals = np.vstack([circle((0.0, 0.0, 0.0), 1.0, way, SIDES)[:-1] for way in along])
    return np.repeat(points, SIDES, axis=0) + np.repeat(radii, SIDES)[:, None] * normals, normals
