# SPDX-License-Identifier: BSD-3-Clause
"""Listens to tf as long as somebody asks for frames of others."""

from __future__ import annotations

import threading
import time
from typing import Final

import rospy
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from rst_control.config.tracking import TrackingConfig
from rst_control.registration.frames import Array, Frames, Link, pose
from rst_control.ros.common.wall_clock import RosClock
from rst_control.types import BASE, Cause
from typed_config.ros.known_publishers import KnownPublishers

PATIENCE: Final = 1.0  # [s] for tf to report a frame that is not known
STEP: Final = 0.02  # [s] between two looks


class FrameListener:
    """Knows frames from `/tf` and `/tf_static`; it begins to listen with the first question.

    Args:
        clock: Translates stamps.
        config: Who publishes frames, and how old one that moves may be.
        known: Makes the subscribers.
    """

    def __init__(self, clock: RosClock, config: TrackingConfig, known: KnownPublishers) -> None:
        self._clock, self._age, self._frames = clock, config.frame_age, Frames()
        self._known, self._names = known, config.frames
        self._lock = threading.Lock()
        self._topics: list[rospy.Subscriber] = []

    def in_base(self, frame: str, patience: float = PATIENCE) -> Array | Cause:
        """Pose of a frame in base_link, shape (4, 4), or why it is not known; waits a while."""
        if frame.strip("/") in ("", BASE):
            return self._look(frame)
        self._listen()
        end = time.monotonic() + patience
        while isinstance(found := self._look(frame), Cause) and time.monotonic() < end:
            time.sleep(STEP)
        return found

    def _look(self, frame: str) -> Array | Cause:
        with self._lock:
            return self._frames.in_base(frame, time.monotonic(), self._age)

    def _listen(self) -> None:
        with self._lock:
            if self._topics:
                return
            known, names = self._known.subscribe, self._names
            self._topics = [
                known("/tf", TFMessage, self._on_moving, names, queue_size=100),
                known("/tf_static", TFMessage, self._on_static, names, queue_size=100),
            ]

    def _on_moving(self, message: TFMessage) -> None:
        for entry in message.transforms:
            self._put(entry, self._clock.steady(entry.header.stamp.to_sec()))

    def _on_static(self, message: TFMessage) -> None:
        for entry in message.transforms:
            self._put(entry, float("inf"))

    def _put(self, entry: TransformStamped, stamp: float) -> None:
        place, turn = entry.transform.translation, entry.transform.rotation
        try:
            T = pose((place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w))
        except ValueError as error:
            rospy.logwarn_throttle(10.0, f"tf: {entry.child_frame_id}: {error}")
            return
        link = Link(entry.header.frame_id.removeprefix("/"), T, stamp)
        with self._lock:
            self._frames.put(entry.child_frame_id, link)
