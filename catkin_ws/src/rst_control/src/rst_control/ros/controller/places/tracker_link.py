# SPDX-License-Identifier: BSD-3-Clause
"""Places that a tracker reports on topics, set or followed; and how it goes, on diagnostics."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Final

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Point, PointStamped, PoseStamped, Quaternion

from rst_control.config.tracking import TrackingConfig
from rst_control.kinematics.rotations import rotation_of
from rst_control.registration.followed_trocar import NEVER, TrackedTrocar
from rst_control.registration.frames import Array
from rst_control.registration.tracked_grasp import TrackedGrasp
from rst_control.registration.tracked_place import Report
from rst_control.registration.trocar_following import TrocarFollowing
from rst_control.ros.common.wall_clock import RosClock
from rst_control.ros.controller.diagnostics import make_status
from rst_control.ros.controller.messages import caller_of, code_of
from rst_control.ros.controller.places.frame_listener import FrameListener
from rst_control.ros.controller.services.admission import answer_of
from rst_control.types import Cause
from typed_config.ros.known_publishers import KnownPublishers

GRASP, TROCAR = "grasp point", "trocar"
NO_WAIT: Final = 0.0  # [s] in a topic's callback
SAY_AGAIN: Final = 10.0  # [s] before the same complaint is made again
PERIOD: Final = 0.2  # [s] between two looks whether a tracked grasp point may be set


class TrackerLink:
    """Listens to `rst_control/tracker/grasp_point`, `.../grasp_pose` and `.../trocar`.

    Args:
        config: Who is believed, and what of it.
        known: Makes the subscribers.
        frames: Knows other frames.
        clock: Translates stamps.
        grasp: Takes the grasp point.
        trocar: Follows the trocar; None: it is fixed, and its reports are only shown.
        home: The trocar of the scene, x y z, base frame, [m].
    """

    def __init__(
        self,
        config: TrackingConfig,
        known: KnownPublishers,
        frames: FrameListener,
        clock: RosClock,
        grasp: TrackedGrasp,
        trocar: TrocarFollowing | None,
        home: Sequence[float],
    ) -> None:
        self._config, self._frames, self._clock = config, frames, clock
        self._grasp, self._trocar = grasp, trocar
        self._tracked = TrackedTrocar(config, np.array(home)) if trocar is None else trocar.tracked
        self._tracker = ""
        self._unknown_frames: dict[str, Cause] = {}  # by what is reported in them
        by = config.tracker
        for name, kind, take in (
            ("grasp_point", PointStamped, self._on_point),
            ("grasp_pose", PoseStamped, self._on_pose),
            ("trocar", PointStamped, self._on_trocar),
        ):
            known.subscribe(f"rst_control/tracker/{name}", kind, take, by, queue_size=10)

    def step(self) -> None:
        """Set the tracked grasp point where it may be; for a thread of its own."""
        time.sleep(PERIOD)
        answer = self._grasp.step(time.monotonic(), self._tracker)
        if answer is not None:
            reply = answer_of(answer)
            log = rospy.loginfo if reply.accepted else rospy.logwarn
            log("tracker: %s", reply.message)

    def status(self) -> DiagnosticStatus:
        """What diagnostics say of trackers."""
        now, words, level, cause = time.monotonic(), [], DiagnosticStatus.OK, None
        if self._config.grasp_point.is_taken:
            cause = self._unknown_frames.get(GRASP) or self._grasp.objection(now)
            words.append(f"grasp point: {cause.words if cause else 'taken at rest'}")
        values = {}
        lost = self._unknown_frames.get(TROCAR) or self._tracked.objection(now)
        if self._trocar is not None or lost is not NEVER:
            cause = lost or cause
            use = "shown only" if self._trocar is None else "followed"
            words.append(f"trocar: {lost.words if lost else use}")
            away = float(np.linalg.norm(self._tracked.shift(now)[0]))
            values["trocar away from the scene's [mm]"] = f"{away * 1e3:.2f}"
        if self._trocar is not None:
            values["followed by [mm]"] = f"{np.linalg.norm(self._trocar.shift) * 1e3:.2f}"
            values["trocar away from the shaft [mm]"] = f"{self._trocar.unfollowed(now) * 1e3:.2f}"
        if cause is not None:
            level = DiagnosticStatus.WARN
        values["reason_code"] = code_of(cause)
        return make_status("tracker", level, "; ".join(words) or "nothing is tracked", values)

    def _on_point(self, message: PointStamped) -> None:
        self._report_grasp(message, message.point, None)

    def _on_pose(self, message: PoseStamped) -> None:
        self._report_grasp(message, message.pose.position, message.pose.orientation)

    def _report_grasp(
        self, message: PointStamped | PoseStamped, point: Point, turn: Quaternion | None
    ) -> None:
        T = self._known_frame(GRASP, message)
        if T is None:
            return
        pull: tuple[float, ...] = ()
        if turn is not None:
            quaternion = [turn.x, turn.y, turn.z, turn.w]
            norm = float(np.linalg.norm(quaternion))
            if not 0.5 < norm < 2.0:  # no number is not
                words = f"tracked grasp pose with a quaternion of length {norm:.2f}, allowed: 1"
                rospy.logwarn_throttle(SAY_AGAIN, words)
                return
            pull = tuple((T[:3, :3] @ rotation_of(quaternion))[:, 2].tolist())
        self._tracker = caller_of(message)
        self._grasp.update(self._report(message, T, point, pull))

    def _on_trocar(self, message: PointStamped) -> None:
        T = self._known_frame(TROCAR, message)
        if T is None:
            return
        report = self._report(message, T, message.point)
        if self._trocar is None:
            self._tracked.update(report)
        else:
            self._trocar.take(report)

    def _known_frame(self, what: str, message: PointStamped | PoseStamped) -> Array | None:
        found = self._frames.in_base(message.header.frame_id, NO_WAIT)
        if isinstance(found, Cause):
            self._unknown_frames[what] = found
            return None
        self._unknown_frames.pop(what, None)
        return found

    def _report(
        self,
        message: PointStamped | PoseStamped,
        T: Array,
        point: Point,
        pull: tuple[float, ...] = (),
    ) -> Report:
        place = np.array([point.x, point.y, point.z])
        stamp = self._clock.steady(message.header.stamp.to_sec())
        return Report(T[:3, :3] @ place + T[:3, 3], stamp, pull, time.monotonic())
