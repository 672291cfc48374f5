# SPDX-License-Identifier: BSD-3-Clause
"""Scenes for the feasibility gate where the tool is near the arm, or the arm near a singularity."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rst_control.config import MotionConfig
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.robot_model import RobotModel
from rst_control.types import unit_vector

Array = NDArray[np.float64]
STRAY: Final = 0.02  # [rad] of each joint from the postures below
DEPTH: Final = (0.13, 0.19)  # [m] from the shaft's upper end to the trocar
TILT: Final = 0.4  # [rad] of the way in from the jaws' direction, at most, about each axis
SKEW: Final = 0.2  # [rad] of the pull from the way out, at most, about each axis

# Found by drawing joints: tool 20 to 30 mm from upper arm, shoulder or base.
CROWDED: Final = np.array(
    [
        [1.466, 1.215, -0.259, 2.202, 2.801, -1.619, 2.267, -0.095, 0.491],
        [1.233, -1.309, 1.871, 2.079, -0.117, 1.597, -1.985, 0.398, 0.465],
        [1.314, -1.458, 2.307, 2.249, 0.125, 1.183, 0.125, 0.271, -0.358],
        [-0.493, 0.97, 2.538, 2.086, 0.085, 1.698, -2.417, 0.235, 0.046],
        [-1.045, -1.289, -2.162, 2.119, 0.079, 1.597, -0.506, -0.225, -0.047],
        [2.249, -0.948, -0.63, -2.076, 0.024, -1.561, -2.608, 0.304, 0.181],
        [-1.706, -1.274, 2.501, -2.095, 0.174, -1.701, 0.987, 0.117, 0.548],
        [2.01, -1.092, -1.927, 2.166, 0.192, 1.676, -2.704, -0.116, -0.492],
        [2.587, -0.044, 2.786, 2.22, 0.275, 1.733, 2.077, -0.278, -0.157],
        [0.329, 0.543, 0.619, 2.209, 2.83, -1.64, -2.702, 0.395, 0.16],
    ]
)
# Found by drawing joints: manipulability 1.2e-7 to 1.7e-7, nothing near the arm.
STRETCHED: Final = np.array(
    [
        [2.606, -0.576, -1.57, 0.099, 0.802, 1.554, 0.466, -0.279, 0.516],
        [-1.215, 0.007, 2.264, -0.613, 0.287, 1.234, -0.901, 0.298, 0.114],
        [-0.715, 0.684, -0.89, -0.197, 2.755, -0.978, 2.006, -0.504, 0.56],
        [0.449, 0.63, -0.269, -0.534, -1.366, 0.285, 2.428, 0.408, -0.363],
        [-1.648, -0.393, 1.457, 1.984, 1.717, -0.256, 2.645, -0.131, -0.084],
        [1.235, 0.302, -0.742, -0.86, 2.51, -0.041, -2.345, -0.23, 0.547],
        [0.384, 1.259, 2.486, 0.446, 2.438, 0.026, 0.12, 0.025, -0.411],
        [-1.343, 0.236, -0.169, 0.301, 2.604, 1.234, -1.02, -0.551, 0.192],
        [-2.765, 0.465, 0.881, 0.341, 0.847, -0.479, -0.182, 0.489, 0.55],
        [1.66, -0.532, 1.599, -0.273, -1.333, -0.479, -0.717, 0.477, 0.156],
    ]
)


def near(postures: Array, rng: np.random.Generator) -> Array:
    """Joints (9,) [rad] about one of the postures."""
    q: Array = postures[rng.integers(len(postures))] + rng.uniform(-STRAY, STRAY, 9)
    return q


def working_at(
    config: MotionConfig, model: RobotModel, q: Array, rng: np.random.Generator
) -> MotionConfig:
    """The same settings where the robot works at q: a trocar round its shaft, tissue before it."""
    scene, frames = config.scene, Configuration(model, q).frames
    along, T = frames[forward.SHAFT, :, 2], frames[forward.TIP]
    approach = unit_vector(-T[:, 1] + rng.uniform(-TILT, TILT, 3))
    back, grasp = -approach, T[:, 3] + 2.0 * scene.clearance * approach
    tissue = replace(
        scene.tissue,
        centre=_point(grasp - 0.5 * scene.tissue.size[0] * back),
        along=_point(back),
        across=_point(unit_vector(T[:, 2] - back * float(back @ T[:, 2]))),
        reference_point=_point(grasp),
        reference_pull=_point(0.01 * back),
    )
    scene = replace(
        scene,
        tissue=tissue,
        trocar=_point(frames[forward.SHAFT, :, 3] + rng.uniform(*DEPTH) * along),
        home=tuple(q.tolist()),
        workspace_centre=_point(T[:, 3]),
        grasp_point=_point(grasp),
        approach_axis=_point(approach),
        jaw_axis=_point(T[:, 2]),
        pull_direction=_point(unit_vector(back + rng.uniform(-SKEW, SKEW, 3))),
        outward=_point(-along),
    )
    return replace(config, scene=scene)


def with_clearance(config: MotionConfig, clearance: float) -> MotionConfig:
    """The same settings with another distance [m] to keep."""
    return replace(config, collision=replace(config.collision, clearance=clearance))


def with_manipulability(config: MotionConfig, minimum: float) -> MotionConfig:
    """The same settings with another minimum of the manipulability."""
    return replace(config, limits=replace(config.limits, min_manipulability=minimum))


def _point(vector: Array) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
