# SPDX-License-Identifier: BSD-3-Clause
"""The endoscope's optics and place, by topic, and the sheet of tissue, by the settings."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import CameraInfo

from rst_control.config import SceneConfig
from rst_control.kinematics.rotations import rotation_of
from rst_control.tissue.sheet import rest_points, sheet_normal
from rst_control.types import BASE
from typed_config import ConfigError, load_config
from voice_assist.config.display import PictureConfig
from voice_assist.display.picking import Camera, NotOnTissueError, Sheet, StampedHistory
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
    matrix = numbers[7:].reshape(3, 3)
    length = float(np.linalg.norm(numbers[3:7]))
    if not (np.isfinite(numbers).all() and abs(length - 1.0) < 1e-3 and matrix[0, 0] > 0.0):
        raise NotOnTissueError("the endoscope's pose or optics are no usable numbers")
    if abs(np.linalg.det(matrix)) < 1e-9 or not (info.width and info.height):
        raise NotOnTissueError("the endoscope's optics are no usable numbers")
    T = np.eye(4)
    T[:3, :3] = rotation_of(numbers[3:7])
    T[:3, 3] = numbers[:3]
    roi, size = info.roi, (int(info.width), int(info.height))
    width, height = roi.width or size[0], roi.height or size[1]
    region = (roi.x_offset, roi.y_offset, roi.x_offset + width, roi.y_offset + height)
    return Camera(matrix, T, size, region)


def _sheet(read: Callable[..., object] = rospy.get_param) -> Sheet:
    given = read(SCENE, None)
    if given is None:
        raise NotOnTissueError("no controller was launched")
    try:
        tissue = load_config(SceneConfig, given, "scene.yaml").tissue
    except ConfigError as error:
        raise NotOnTissueError(f"the controller's scene cannot be read: {error}") from None
    return Sheet(rest_points(tissue), sheet_normal(tissue))
