# SPDX-License-Identifier: BSD-3-Clause
"""Homogeneous transforms as geometry_msgs/Pose."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion
from numpy.typing import NDArray

from rst_control.kinematics.rotations import quaternion


def pose_message(T: NDArray[np.float64]) -> Pose:
    """The pose of a transform, shape (4, 4) [m]."""
    return Pose(Point(*T[:3, 3].tolist()), Quaternion(*quaternion(T[:3, :3])))
