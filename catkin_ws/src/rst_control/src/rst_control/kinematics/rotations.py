# SPDX-License-Identifier: BSD-3-Clause
"""Rotation matrices in other forms, by KDL: importing scipy takes a third of a node's start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import PyKDL
from numpy.typing import NDArray

Array = NDArray[np.float64]


def roll_pitch_yaw(R: Array) -> Array:
    """Angles about the fixed axes x, y and z [rad]; the inverse of `robot_model.rotation`."""
    return np.array(PyKDL.Rotation(*R.ravel().tolist()).GetRPY())


def quaternion(R: NDArray[np.floating[Any]]) -> tuple[float, float, float, float]:
    """Unit quaternion x, y, z, w."""
    x, y, z, w = PyKDL.Rotation(*R.ravel().tolist()).GetQuaternion()
    return float(x), float(y), float(z), float(w)


def rotation_of(turn: Sequence[float] | Array) -> Array:
    """Rotation matrix (3, 3) of a quaternion x, y, z, w of any length.

    Raises:
        ValueError: Its norm is zero.
    """
    norm = float(np.linalg.norm(turn))
    if norm == 0.0:
        raise ValueError("a quaternion of norm zero")
    unit = PyKDL.Rotation.Quaternion(*(float(part) / norm for part in turn))
    return np.array([[unit[row, column] for column in range(3)] for row in range(3)])


def turned(vector: Array) -> Array:
    """Rotation matrix (3, 3) of a rotation vector (3,) [rad] (Rodrigues 1840)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R: Array = np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K
    return R
