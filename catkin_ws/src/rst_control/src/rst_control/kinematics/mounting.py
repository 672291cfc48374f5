# SPDX-License-Identifier: BSD-3-Clause
"""How the arm is mounted: where gravity points in the frame of its base."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from rst_control.errors import RobotModelError
from rst_control.kinematics.robot_model import RobotModel
from rst_control.types import Vector, frozen_array, unit_vector

GRAVITY: Final = 9.81  # [m/s^2]
DOWN: Final = np.array([0.0, 0.0, -1.0])
SAME_WAY: Final = np.radians(1.0)  # [rad] between the setting and the URDF's root, at most


def gravity_in_base(model: RobotModel, setting: Sequence[float] = ()) -> Vector:
    """Gravity in the base frame [m/s^2]. Shape (3,).

    Gravity points along -z of the URDF's root. A URDF that turns base_link against its root says
    how the base is mounted; the setting may then say nothing else.

    Args:
        model: The robot.
        setting: `scene.gravity`, the way of gravity in base_link; empty: as the URDF says.

    Raises:
        RobotModelError: The URDF says another way than the setting.
    """
    R = model.T_root_base[:3, :3]
    by_root = R.T @ DOWN
    if not len(setting):
        return frozen_array(GRAVITY * by_root, 3)
    way = unit_vector(setting)
    is_turned = angle_between(by_root, DOWN) > SAME_WAY
    if is_turned and (angle := angle_between(way, by_root)) > SAME_WAY:
        raise RobotModelError(
            f"scene.gravity is {way_words(way)}, and the URDF's root has {way_words(by_root)}, "
            f"{np.degrees(angle):.1f} deg from it; allowed: {np.degrees(SAME_WAY):.0f} deg, or "
            "gravity: [] to take the URDF's"
        )
    return frozen_array(GRAVITY * way, 3)


def angle_between(first: Vector, second: Vector) -> float:
    """Angle between two ways [rad], both of shape (3,)."""
    across = float(np.linalg.norm(np.cross(first, second)))
    return float(np.arctan2(across, first @ second))


def way_words(way: Vector) -> str:
    """A way for people, of length 1. Shape (3,)."""
    return "[" + ", ".join(f"{x + 0.0:.3f}" for x in unit_vector(way).round(3)) + "]"
