# SPDX-License-Identifier: BSD-3-Clause
"""The simulated cameras as a pinhole model: where they are, and where in a picture a point is."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rst_control.config import CameraConfig

Array = NDArray[np.float64]


def camera_pose(camera: CameraConfig) -> Array:
    """Pose of the optical frame in base_link: x right, y down, z into the picture. Shape (4, 4)."""
    yaw, pitch = camera.yaw, camera.pitch
    level = math.cos(pitch)
    forward = np.array([-math.sin(yaw) * level, math.cos(yaw) * level, math.sin(pitch)])
    right = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    T = np.eye(4)
    T[:3, 0], T[:3, 1], T[:3, 2] = right, np.cross(forward, right), forward
    T[:3, 3] = np.array(camera.target) - camera.distance * forward
    return T


def camera_matrix(camera: CameraConfig, left: int) -> Array:
    """Intrinsic matrix in pixels of a picture of several cameras side by side. Shape (3, 3).

    Args:
        camera: One of them.
        left: Pixels of the picture that lie left of it.
    """
    width, height = camera.size
    focal = 0.5 * height / math.tan(0.5 * camera.field_of_view)
    return np.array([[focal, 0.0, left + 0.5 * width], [0.0, focal, 0.5 * height], [0.0, 0.0, 1.0]])
