# SPDX-License-Identifier: BSD-3-Clause
"""Grasp candidates: how the jaws may take a sheet of tissue and pull it, the squarest first.

The sheet lies between the jaws where they come from its free side within its plane, and open across
it. The jaws may come along the shaft, which bends the wrist least, or tilted from there within the
sheet; and they may stand a little askew of it, turned about the way they come.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rst_control.config import SceneConfig
from rst_control.kinematics.rotations import turned
from rst_control.tissue.sheet import free_sides, rest_points, rim_nodes, sheet_normal
from rst_control.tissue.triangulation import best_anchors, pull_direction
from rst_control.types import Vector, unit_vector

Array = NDArray[np.float64]

TILTS: Final = (0.0, 0.3, -0.3, 0.6, -0.6, 0.9, -0.9)  # [rad] from the shaft, within the sheet
MAX_ASIDE: Final = math.radians(75.0)  # of the approach from the way straight in
NEAR_SIDE: Final = 0.5  # of the clearance: a free side so near may be come over
TURNS: Final = (0.0, 0.4, -0.4, 0.7, -0.7, 1.0, -1.0)  # [rad] of the jaws about their approach
# A pull by this share of the way from the anchors to the grasp strains the sheet by about as much
# on the average, and next to the jaws by not much more than half again.
LONGEST_PULL: Final = 0.35


@dataclass(frozen=True, eq=False)
class GraspCandidate:
    """One grasp of the sheet, and the pull from it."""

    T_base_tip: Array  # (4, 4), pose of tool_tip in base_link: jaws along -y, opening about z
    pull: Vector  # (3,), unit, base frame
    length: float  # [m] that it may be pulled, at most
    askew: float  # [rad] of the jaws from square to the sheet


def grasp_candidates(scene: SceneConfig) -> tuple[GraspCandidate, ...]:
    """All grasps that a scene leaves open; just one where it names approach and jaw axis.

    Args:
        scene: Sheet, grasp point, trocar; and directions, where they are not left open.
    """
    rim = rest_points(scene.tissue)[rim_nodes(scene.tissue)]
    grasp, normal = np.array(scene.grasp_point), sheet_normal(scene.tissue)
    pull, length = np.array(scene.pull_direction), scene.max_displacement
    if not scene.pull_direction:
        pull = pull_direction(rim, grasp)
        height = float(np.linalg.norm(grasp - best_anchors(rim, grasp).mean(axis=0)))
        length = min(length, LONGEST_PULL * height)
    pull = pull / np.linalg.norm(pull)
    candidates = []
    for approach, turn in product(_approaches(scene, normal), _turns(scene)):
        axis = np.array(scene.jaw_axis) if scene.jaw_axis else np.cross(normal, approach)
        T = grasp_pose(grasp, approach, turned(turn * approach) @ axis)
        across = float(abs(T[:3, 0] @ normal))  # the jaws close along x
        candidates.append(GraspCandidate(T, pull, length, math.acos(min(1.0, across))))
    return tuple(sorted(candidates, key=lambda candidate: round(candidate.askew, 6)))


def grasp_pose(point: Vector, approach: Vector, axis: Vector) -> Array:
    """Pose of tool_tip in base_link with the jaws along an approach. Shape (4, 4).

    Args:
        point: Between the tips of the jaws, base frame, [m]. Shape (3,).
        approach: Way that the jaws point. Shape (3,).
        axis: About which they open; what is not square to the approach does not count. Shape (3,).
    """
    y = -unit_vector(approach)
    z = unit_vector(axis)
    z = unit_vector(z - y * float(y @ z))
    T = np.eye(4)
    T[:3, 0], T[:3, 1], T[:3, 2] = np.cross(y, z), y, z
    T[:3, 3] = point
    return T


def _turns(scene: SceneConfig) -> tuple[float, ...]:
    return (0.0,) if scene.jaw_axis else TURNS


def _approaches(scene: SceneConfig, normal: Vector) -> list[Vector]:
    """Unit vectors within the sheet from its free sides, the one along the shaft first."""
    if scene.approach_axis:
        return [unit_vector(scene.approach_axis)]
    straight = _ways_in(scene)
    shaft = np.array(scene.grasp_point) - scene.trocar
    shaft = unit_vector(shaft - normal * float(normal @ shaft))
    tilted = [turned(tilt * normal) @ shaft for tilt in TILTS]
    near = [way for way in tilted if (straight @ way).max() >= math.cos(MAX_ASIDE)]
    return near or list(straight)


def _ways_in(scene: SceneConfig) -> Array:
    """Unit vectors straight in over each free side that is near the grasp. Shape (n, 3).

    Where none is near, over the nearest; where all sides are held, along the sheet.
    """
    grasp, sides = np.array(scene.grasp_point), free_sides(scene.tissue)
    if not sides:
        return np.array([unit_vector(scene.tissue.along)])
    away = [float((point - grasp) @ outward) for point, outward in sides]
    reach = max(min(away), NEAR_SIDE * scene.clearance)
    near = [-side[1] for side, far in zip(sides, away, strict=True) if far <= reach]
    return np.array(near)
