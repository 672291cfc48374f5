# SPDX-License-Identifier: BSD-3-Clause
"""Keeps tool, arm, base and table apart: capsules that are checked along a whole path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rst_control.config.collision import CollisionConfig
from rst_control.errors import Collision, RobotModelError
from rst_control.kinematics import forward
from rst_control.kinematics.robot_model import MOVING, RobotModel
from rst_control.planning import collision_kernels as kernels
from rst_control.trajectory.path import Samples
from rst_control.types import Vector, unit_vector

Array = NDArray[np.float64]
TABLE: Final = "table"


@dataclass(frozen=True)
class Plane:
    """A surface that some bodies must stay above."""

    name: str
    normal: Sequence[float]  # (3,), unit, base frame, to the free side
    offset: float  # [m] of the surface from the base frame's origin, along the normal
    clearance: float  # [m] that bodies keep from it
    exempt: tuple[str, ...]  # links that may touch it or reach through it


@dataclass(frozen=True)
class Clearance:
    """The two that are nearest to what they must keep."""

    distance: float  # [m], negative: they overlap
    first: str
    second: str
    allowed: float  # [m]


class CollisionModel:
    """The robot's capsules and what each must keep clear of. It never changes.

    Args:
        config: Shapes and distances.
        model: The robot.
        planes: Surfaces beside the table.

    Raises:
        RobotModelError: A body is on, or a pair names, a link that the robot does not have.
    """

    def __init__(
        self, config: CollisionConfig, model: RobotModel, planes: tuple[Plane, ...] = ()
    ) -> None:
        self._chain = model.chain
        self._names = tuple(body.name for body in config.bodies)
        if config.has_table:
            normal = unit_vector(config.table_normal).tolist()
            table = Plane(TABLE, normal, config.table_height, config.clearance, model.standing)
            planes = (table, *planes)
        self._planes = planes
        self.shapes = _shapes(config, model, planes)

    def clearance(self, q: Vector) -> Clearance:
        """What is nearest to what it must keep at q (9,) [rad]."""
        return self._clearance(*kernels.min_room(self._chain, np.array(q), self.shapes))

    def check(self, samples: Samples) -> None:
        """Check a path at its samples and everywhere between them.

        Raises:
            Collision: Two come nearer than allowed; names both.
        """
        spacing = float(samples.s[1] - samples.s[0])
        room, which = kernels.sweep(self._chain, samples.q, spacing, self.shapes)
        if not room >= 0.0:  # no number: refused, too
            found = self._clearance(room, which)
            raise Collision(found.first, found.second, found.distance, found.allowed)

    def _clearance(self, room: float, which: int) -> Clearance:
        pairs, plane_pairs = self.shapes.pairs, self.shapes.plane_pairs
        if which < len(pairs):
            first, second = (self._names[body] for body in pairs[which])
            allowed = self.shapes.allowed
        else:
            body, number = plane_pairs[which - len(pairs)]
            plane = self._planes[number]
            first, second, allowed = self._names[body], plane.name, plane.clearance
        return Clearance(room + allowed, first, second, allowed)


def _shapes(
    config: CollisionConfig, model: RobotModel, planes: tuple[Plane, ...]
) -> kernels.Shapes:
    rows, bodies = _rows(model), config.bodies
    named = [body.link for body in bodies]
    named += [link for entry in config.left_out for link in (entry.link, *entry.others)]
    for link in named:
        if link not in rows:
            raise RobotModelError(f"collision body on {link!r}, allowed: {', '.join(rows)}")
    apart = {frozenset((entry.link, o)) for entry in config.left_out for o in entry.others}
    pairs = [
        (a, b)
        for a, b in combinations(range(len(bodies)), 2)
        if bodies[a].link != bodies[b].link
        and frozenset((bodies[a].link, bodies[b].link)) not in apart
    ]
    plane_pairs = [
        (n, k)
        for k, plane in enumerate(planes)
        for n, body in enumerate(bodies)
        if body.link not in plane.exempt
    ]
    capsules = np.array([[*body.start, *body.end, body.radius] for body in bodies])
    frames = np.array([rows[body.link] for body in bodies])
    surfaces = [[*plane.normal, plane.offset, plane.clearance] for plane in planes]
    return kernels.Shapes(
        capsules,
        frames,
        np.array(pairs, dtype=np.int64).reshape(-1, 2),
        np.array(plane_pairs, dtype=np.int64).reshape(-1, 2),
        np.array(surfaces, dtype=np.float64).reshape(-1, 5),
        config.clearance,
        _reach(model.chain, capsules, frames),
    )


def _rows(model: RobotModel) -> dict[str, int]:
    """Row of `forward.forward`'s frames by the name of the link."""
    turning = [n for n in range(len(MOVING)) if n not in model.locked]  # others have no axis
    rows = {model.link_of[MOVING[row]]: row for row in turning}
    fixed = {"tool0": forward.TOOL0, "interface_link": forward.SHAFT}
    return {"base_link": kernels.BASE, **rows, **fixed}


def _reach(transforms: Array, capsules: Array, frames: NDArray[np.int64]) -> Array:
    """Furthest that a capsule's line can be from each joint, if the arm were straight [m]. (9,)."""
    offsets = np.linalg.norm(transforms[:, :, 3], axis=1)
    ends = np.linalg.norm(capsules[:, :6].reshape(-1, 2, 3), axis=2).max(axis=1)
    reach = np.zeros(9)
    for joint in range(9):
        for row, end in zip(frames, ends, strict=True):
            last = 6 if row in (forward.SHAFT, forward.TOOL0) else row
            if last >= joint:
                along = offsets[joint + 1 : last + 1].sum() + (offsets[row] if row != last else 0.0)
                reach[joint] = max(reach[joint], along + end)
    return reach
