# SPDX-License-Identifier: BSD-3-Clause
"""What a picture shows beside the robot: table, abdominal wall with trocar, tissue on pins."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pybullet
from numpy.typing import NDArray

from rst_control.config import SceneConfig
from rst_control.simulation.rendering.sheet_mesh import (
    Points,
    SheetStretch,
    grid_faces,
    node_normals,
    strain_colours,
    strain_share,
)
from rst_control.tissue.sheet import rest_points, rim_nodes

Colour = tuple[float, float, float, float]

SKIN: Colour = (0.93, 0.72, 0.60, 1.0)
RIM: Colour = (0.10, 0.45, 0.75, 1.0)
PIN: Colour = (0.20, 0.22, 0.26, 1.0)
TABLE: Colour = (0.55, 0.66, 0.70, 1.0)
BED: Colour = (0.80, 0.47, 0.42, 1.0)
STRAIN_COLOURS = 12
WALL_RADIUS, WALL_DOME = 0.11, 0.018  # [m] of the patch of abdominal wall, and how far it bulges
PORT_RADIUS, PORT_LENGTH = 0.0065, 0.035  # [m] of the trocar's tube
PIN_RADIUS = 0.0018  # [m]
BED_MARGIN, BED_DOME = 0.075, 0.035  # [m] of the mound around the rim, and how far it falls off
SAME = 2e-5  # [m] a sheet moved by less is not drawn again
THICKNESS = 0.0012  # [m] of the sheet
SLICES = 48
FINENESS = 3  # times finer than its grid the sheet is drawn
EVENING = 4  # times its colours are evened out


class SceneShapes:
    """Bodies without mass in a PyBullet world.

    Args:
        scene: Trocar and tissue.
        client: The world.
    """

    def __init__(self, scene: SceneConfig, client: int) -> None:
        self._on = {"physicsClientId": client}
        columns, rows = scene.tissue.nodes
        self._finer = np.kron(_finer(columns), _finer(rows))
        self._faces = grid_faces(FINENESS * (columns - 1) + 1, FINENESS * (rows - 1) + 1)
        rest = self._finer @ rest_points(scene.tissue)
        self._stretch = SheetStretch(rest, self._faces)
        self._tissue: list[int] = []
        self._shown: Points | None = None
        self._add_table()
        self._add_wall(np.array(scene.trocar))
        rim = rest_points(scene.tissue)[rim_nodes(scene.tissue)]
        self._add_pins(rim)
        self._add_bed(rim)

    def show_tissue(self, nodes: Points) -> None:
        """Put the sheet where its nodes are; the more it is stretched the darker it is.

        Args:
            nodes: Base frame, [m]. Shape (columns * rows, 3).
        """
        if self._shown is not None and np.abs(nodes - self._shown).max() < SAME:
            return
        self._shown = nodes.copy()
        for body in self._tissue:
            pybullet.removeBody(body, **self._on)
        nodes = self._finer @ nodes
        share = strain_share(self._strain(nodes))
        groups = np.minimum((share * STRAIN_COLOURS).astype(int), STRAIN_COLOURS - 1)
        normals = node_normals(nodes, self._faces)
        self._tissue = []
        for group in np.unique(groups):
            tint = np.array([group / (STRAIN_COLOURS - 1)])
            red, green, blue = strain_colours(tint)[0].tolist()
            used, faces = np.unique(self._faces[groups == group], return_inverse=True)
            for side in (0.5 * THICKNESS, -0.5 * THICKNESS):
                outward = normals[used] * np.sign(side)
                points = nodes[used] + abs(side) * outward
                turned = faces.reshape(-1, 3)[:, :: 1 if side > 0 else -1]
                self._tissue.append(self._mesh(points, outward, turned, (red, green, blue, 1.0)))

    def _strain(self, nodes: Points) -> NDArray[np.float64]:
        """Largest stretch of each triangle, evened out over its neighbours [-]."""
        stretch = self._stretch.of_faces(nodes)
        for _ in range(EVENING):
            stretch = self._stretch.at_points(stretch)[self._faces].mean(axis=1)
        return stretch

    def _add_table(self) -> None:
        shape = pybullet.createVisualShape(
            pybullet.GEOM_BOX,
            halfExtents=[0.6, 0.45, 0.01],
            rgbaColor=TABLE,
            specularColor=[0, 0, 0],
            **self._on,
        )
        self._place(shape, (0.25, 0.0, -0.011))

    def _add_wall(self, trocar: Points) -> None:
        rings = np.linspace(PORT_RADIUS, WALL_RADIUS, 14)
        points = _rings(trocar, rings, -WALL_DOME * (rings / WALL_RADIUS) ** 2)
        faces = grid_faces(len(rings), SLICES, closed=True)
        normals = node_normals(points, faces)
        for side in (1.0, -1.0):
            shifted = points + 0.001 * side * normals
            self._mesh(shifted, side * normals, faces if side > 0 else faces[:, ::-1], SKIN)
        self._add_port(trocar)

    def _add_port(self, trocar: Points) -> None:
        for radius, length, centre in (
            (PORT_RADIUS, PORT_LENGTH, 0.0),
            (2.2 * PORT_RADIUS, 0.010, 0.5 * PORT_LENGTH),
        ):
            points = _rings(np.zeros(3), [radius] * 2, [0.5 * length, -0.5 * length])
            faces = grid_faces(2, SLICES, closed=True)
            normals = points * [1.0, 1.0, 0.0] / radius
            self._mesh(trocar + points + [0, 0, centre], normals, faces, RIM)
            self._mesh(trocar + points + [0, 0, centre], -normals, faces[:, ::-1], RIM)

    def _add_pins(self, places: Points) -> None:
        for place in places:
            shape = pybullet.createVisualShape(
                pybullet.GEOM_SPHERE, radius=PIN_RADIUS, rgbaColor=PIN, **self._on
            )
            self._place(shape, tuple(place))

    def _add_bed(self, rim: Points) -> None:
        """A mound under the lowest part of the rim, down to the table."""
        lowest = rim[rim[:, 2] < rim[:, 2].min() + 0.005]
        middle = lowest.mean(axis=0)
        radius = float(np.linalg.norm(lowest - middle, axis=1).max()) + BED_MARGIN
        level = np.linspace(0.02, 0.5 * np.pi, 12)
        rings = np.append(radius * np.sin(level), radius)
        heights = np.append(-BED_DOME * (1.0 - np.cos(level)), -middle[2])
        points = _rings(middle, rings, heights)
        faces = grid_faces(len(rings), SLICES, closed=True)
        self._mesh(points, node_normals(points, faces), faces, BED)

    def _mesh(
        self, points: Points, normals: Points, faces: NDArray[np.int64], colour: Colour
    ) -> int:
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=points.tolist(),
            indices=faces.ravel().tolist(),
            normals=normals.tolist(),
            rgbaColor=colour,
            specularColor=[0.1, 0.1, 0.1],
            **self._on,
        )
        return self._place(shape, (0.0, 0.0, 0.0))

    def _place(self, shape: int, place: tuple[float, ...]) -> int:
        return int(
            pybullet.createMultiBody(
                baseMass=0.0, baseVisualShapeIndex=shape, basePosition=place, **self._on
            )
        )


def _finer(count: int) -> NDArray[np.float64]:
    """Weights that put points between `count` points in a row, FINENESS to each gap."""
    place = np.arange(FINENESS * (count - 1) + 1) / FINENESS
    weights: NDArray[np.float64] = np.maximum(
        1.0 - np.abs(place[:, None] - np.arange(count)[None, :]), 0.0
    )
    return weights


def _rings(centre: Points, radii: Iterable[float], heights: Iterable[float]) -> Points:
    """Level circles about a centre, each of SLICES points."""
    angles = np.linspace(0.0, 2.0 * np.pi, SLICES, endpoint=False)
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(SLICES)])
    circles = [r * ring + [0.0, 0.0, h] for r, h in zip(radii, heights, strict=True)]
    return centre + np.vstack(circles)
