# SPDX-License-Identifier: BSD-3-Clause
"""Rotation matrices in other forms, by KDL: scipy's import is a third of the simulator's start."""

from __future__ import annotations

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
