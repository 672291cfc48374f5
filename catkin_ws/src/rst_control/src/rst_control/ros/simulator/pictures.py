# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the scene on request, and the window; both are drawn by processes of their own."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import CameraInfo, CompressedImage
from std_srvs.srv import Trigger, TriggerResponse

from rst_control.config import SimulationConfig
from rst_control.ros.common.pose_message import pose_message
from rst_control.simulation.camera_geometry import camera_matrix, camera_pose
from rst_control.simulation.rendering.state import SceneSetup, SceneState
from rst_control.simulation.rendering.worker import SceneLostError, SceneWorker
from rst_control.types import BASE

log = logging.getLogger("rosout.rst_control.pictures")

ENDOSCOPE = "endoscope"  # frame of its optics
WINDOW_PERIOD = 0.1  # [s] between two states of the window


class SimulatorPictures:
    """Serves `robot/snapshot`, and keeps the window up to date where there is one.

    Args:
        config: Scene and cameras.
        urdf: Model of the robot.
        copy_state: Takes a copy of the present state, from any thread.

    Raises:
        SceneLostError: The window cannot be opened; says why.
    """

    def __init__(
        self, config: SimulationConfig, urdf: Path, copy_state: Callable[[], SceneState]
    ) -> None:
        self._config, self._urdf, self._copy_state = config, urdf, copy_state
        self._painter: SceneWorker | None = self._start(window=False)
        self._lock = threading.Lock()
        self._topic = rospy.Publisher(
            "robot/scene/compressed", CompressedImage, queue_size=2, latch=True
        )
        self._endoscope = [
            rospy.Publisher("robot/scene/camera_info", CameraInfo, queue_size=1, latch=True),
            rospy.Publisher("robot/scene/camera_pose", PoseStamped, queue_size=1, latch=True),
        ]
        for topic, message in zip(self._endoscope, endoscope_messages(config), strict=True):
            topic.publish(message)
        self._window: SceneWorker | None = None
        if config.simulator.gui:
            window = self._window = self._start(window=True)
            window.wait_until_up()
            threading.Thread(target=self._show, args=(window,), name="window", daemon=True).start()
        self._service = rospy.Service("robot/snapshot", Trigger, self._on_snapshot)

    def close(self) -> None:
        """End the drawing processes."""
        for worker in (self._painter, self._window):
            if worker is not None:
                worker.close()

    def _start(self, window: bool) -> SceneWorker:
        simulator = self._config.simulator
        cameras = (simulator.overview, simulator.endoscope)
        return SceneWorker(SceneSetup(self._config.scene, cameras, self._urdf, window))

    def _on_snapshot(self, _: object) -> TriggerResponse:
        with self._lock:
            try:
                picture = self._picture()
            except SceneLostError as error:
                self._painter = None
                return TriggerResponse(False, str(error))
            except TimeoutError as error:
                return TriggerResponse(False, str(error))
        return TriggerResponse(True, f"{len(picture)} bytes of PNG on {self._topic.resolved_name}")

    def _picture(self) -> bytes:
        if self._painter is None:
            self._painter = self._start(window=False)
        message = CompressedImage(format="png")
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = BASE
        message.data = self._painter.picture(self._copy_state())
        self._topic.publish(message)
        return message.data

    def _show(self, window: SceneWorker) -> None:
        """Thread of the window; closing the window ends it, and the simulation goes on."""
        while not rospy.is_shutdown():
            with suppress(TimeoutError):
                try:
                    window.show(self._copy_state())
                except SceneLostError as error:
                    log.warning("%s", error)
                    return
            threading.Event().wait(WINDOW_PERIOD)


def endoscope_messages(config: SimulationConfig) -> tuple[CameraInfo, PoseStamped]:
    """The endoscope's optics in pixels of the whole picture, its region there, and its place."""
    overview, endoscope = config.simulator.overview, config.simulator.endoscope
    left, (width, height) = overview.size[0], endoscope.size
    info = CameraInfo(width=left + width, height=height, distortion_model="plumb_bob")
    info.header.frame_id = ENDOSCOPE
    K = camera_matrix(endoscope, left)
    info.D, info.K, info.R = [0.0] * 5, K.ravel().tolist(), np.eye(3).ravel().tolist()
    info.P = np.hstack([K, np.zeros((3, 1))]).ravel().tolist()
    info.roi.x_offset, info.roi.width, info.roi.height = left, width, height
    pose = PoseStamped(pose=pose_message(camera_pose(endoscope)))
    pose.header.frame_id = BASE
    return info, pose
