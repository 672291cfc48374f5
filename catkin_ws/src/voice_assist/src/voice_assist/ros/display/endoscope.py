# SPDX-License-Identifier: BSD-3-Clause
"""The endoscope's optics and place, by topic, and the sheet of tissue, by the settings."""

from __future__ import annotations

import time

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import CameraInfo

from rst_control.config import SceneConfig
from rst_control.kinematics.rotations import rotation_of
from rst_control.tissue.sheet import rest_points, sheet_normal
from rst_control.types import BASE
from typed_config import ConfigError, load_config
from typed_config.ros.xmlrpc import ANSWER_TIME, FAILURES, parameter
from voice_assist.config.display import PictureConfig
from voice_assist.display.picking import Array, Camera, NotOnTissueError, Sheet, StampedHistory
from voice_assist.ros.believed import Believed

SCENE = "controller/scene"  # parameter


class Endoscope:
    """Follows the camera; turns clicks into points of the tissue.

    Args:
        config: Topics of the camera.
        known: Makes the subscribers.
    """

    def __init__(self, config: PictureConfig, known: Believed) -> None:
        self._info = StampedHistory[CameraInfo](time.monotonic)
        self._pose = StampedHistory[PoseStamped](time.monotonic)
        self._topics = [
            known.hear("camera", config.camera_info, CameraInfo, self._on_info, queue_size=1),
            known.hear("camera", config.camera_pose, PoseStamped, self._on_pose, queue_size=1),
        ]

    def _on_info(self, message: CameraInfo) -> None:
        self._info.add(message.header.stamp.to_sec(), message)

    def _on_pose(self, message: PoseStamped) -> None:
        self._pose.add(message.header.stamp.to_sec(), message)

    def point(self, x: float, y: float, stamp: float) -> tuple[float, ...]:
        """The point of the tissue that is meant, base frame [m].

        Args:
            x: Share of the picture's width.
            y: Share of its height.
            stamp: Of the picture [s].

        Raises:
            NotOnTissueError: There is none, or what the camera saw then is not known.
        """
        camera = camera_of(self._info.at(stamp), self._pose.at(stamp))
        found = _sheet().nearest(camera, x, y)
        return tuple(map(float, found))


def camera_of(info: CameraInfo, pose: PoseStamped) -> Camera:
    """The camera of two messages.

    Raises:
        NotOnTissueError: It is not given as it must be.
    """
    if pose.header.frame_id.lstrip("/") != BASE:
        raise NotOnTissueError(f"the endoscope's pose is in {pose.header.frame_id!r}, not {BASE!r}")
    if any(info.D):
        raise NotOnTissueError("the endoscope's picture is distorted: rectify it")
    p, q = pose.pose.position, pose.pose.orientation
    numbers = np.array([p.x, p.y, p.z, q.x, q.y, q.z, q.w, *info.K])
    roi, size = info.roi, (int(info.width), int(info.height))
    if trouble := _trouble(numbers, size):
        raise NotOnTissueError(f"the endoscope's pose or optics are not usable: {trouble}")
    T = np.eye(4)
    T[:3, :3] = rotation_of(numbers[3:7])
    T[:3, 3] = numbers[:3]
    width, height = roi.width or size[0], roi.height or size[1]
    region = (roi.x_offset, roi.y_offset, roi.x_offset + width, roi.y_offset + height)
    return Camera(numbers[7:].reshape(3, 3), T, size, region)


def _trouble(numbers: Array, size: tuple[int, int]) -> str:
    """Why place, quaternion and K of a camera, in this order, cannot be used; empty: they can."""
    names = ("x", "y", "z", "qx", "qy", "qz", "qw", *(f"K[{i}]" for i in range(9)))
    for name, number in zip(names, numbers, strict=True):
        if not np.isfinite(number):
            return f"{name} is {number:g}"
    length, det = np.linalg.norm(numbers[3:7]), np.linalg.det(numbers[7:].reshape(3, 3))
    if abs(length - 1.0) >= 1e-3:
        return f"the quaternion is {length:.3g} long, allowed: 1"
    if numbers[7] <= 0.0:
        return f"K[0] is {numbers[7]:g}, allowed: above 0"
    if abs(det) < 1e-9:
        return f"the determinant of K is {det:g}, allowed: not 0"
    return "" if all(size) else f"the picture has {size[0]} x {size[1]} pixels"


def _sheet() -> Sheet:
    try:
        given = parameter(rospy.resolve_name(SCENE))
    except FAILURES:
        words = f"the ROS master does not say within {ANSWER_TIME:g} s where the tissue is"
        raise NotOnTissueError(words) from None
    if given is None:
        raise NotOnTissueError("no controller was launched")
    try:
        tissue = load_config(SceneConfig, given, "scene.yaml").tissue
    except ConfigError as error:
        raise NotOnTissueError(f"the controller's scene cannot be read: {error}") from None
    return Sheet(rest_points(tissue), sheet_normal(tissue))
