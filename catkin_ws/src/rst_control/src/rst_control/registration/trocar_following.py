# SPDX-License-Identifier: BSD-3-Clause
"""A robot that follows its trocar, seen from a controller for which the trocar stands still.

What the controller sends is changed so that the shaft goes with the trocar while the tip stays, and
what it receives is changed back. So all plans, watchdogs and brakes hold towards the trocar as it
moves. The trocar is followed while the controller is active, from "hey robot" to "stop" or
"terminate". A tracker that is not believed is a fault of the robot: the controller brakes and
latches, and the shaft stays where it is.

A controller that starts, or a robot that was guided by hand, may hold the shaft in a trocar that
has moved already. While nothing is sent, the shift that the joints hold is found from them. A shaft
in the patient and in neither trocar is a fault: what is followed would lever on the body wall.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from rst_control.config import MotionConfig
from rst_control.kinematics.configuration import Configuration, planning_joints, robot_joints
from rst_control.kinematics.moved_trocar import held_shift, shifted_joints
from rst_control.kinematics.rcm import rcm_state
from rst_control.kinematics.robot_model import RobotModel
from rst_control.planning.patient_surface import TrocarPose
from rst_control.registration.followed_trocar import TrackedTrocar
from rst_control.registration.tracked_place import Report
from rst_control.robot.backend import RobotBackend
from rst_control.robot.sent_changes import ChangedRobot
from rst_control.supervision.plausibility import FrozenJoints, kept_open
from rst_control.types import ACTIVE_STATES, Cause, Measurement, Reason, Setpoint, State, Vector

CATCH_UP: Final = 0.1  # [s] in which a distance from the trocar is made up for
NEAR: Final = 0.3  # share of the allowed distance, within which the shaft has caught up


class TrocarFollowing(ChangedRobot):
    """Follows the trocar on the way to and from another robot.

    Args:
        robot: What moves.
        config: Settings; `scene.trocar` is the trocar where it is expected.
        model: The robot.
        state: What the controller is doing.
        trocar_pose: Where the tool is towards the trocar, for joint positions of shape (10,).
    """

    def __init__(
        self,
        robot: RobotBackend,
        config: MotionConfig,
        model: RobotModel,
        state: Callable[[], State],
        trocar_pose: Callable[[Vector], TrocarPose],
    ) -> None:
        settings, sensors = config.controller, config.controller.watchdogs.sensors
        super().__init__(robot, settings.tension.delay, state)
        self._model, self._config = model, settings.tracking.trocar
        self._trocar_pose = trocar_pose
        self._trocar, self._tolerance = np.array(config.scene.trocar), config.rcm.measured_tolerance
        self.tracked = TrackedTrocar(settings.tracking, self._trocar)
        after = sensors.frozen_after + settings.watchdogs.joint_state_age + self._lag
        self._frozen = FrozenJoints(sensors.frozen_way, after)
        self.shift, self._speed = np.zeros(3), np.zeros(3)  # [m] followed so far, and [m/s]
        self._is_near = False  # it caught up with the trocar since it began to follow
        self._sent: Vector | None = None  # newest set-point; None: the robot holds by itself
        self._beside: float | None = None  # [m] of a held shaft off the trocar; None: it is in one

    def take(self, report: Report) -> None:
        """Take in where a tracker sees the trocar."""
        self.tracked.update(report)

    def _taken_in(self, measured: Measurement) -> Measurement:
        """The joints as if the trocar had not moved, and whether it may be followed."""
        if self._raw is not None:  # nothing is left of what was sent to a robot with a fault
            sent = None if self._raw.fault else kept_open(measured, self._sent)
            self._frozen.update(self._raw, measured, sent)
        is_found = self._sent is None and self._find_shift(measured)
        fault = measured.fault or self._fault(measured.stamp)
        seen = replace(self.noted.undone(measured), fault=fault)
        # the joints as the controller has them jump, as of a robot that was lost meanwhile
        return replace(seen, connected=False) if is_found else seen

    def _find_shift(self, measured: Measurement) -> bool:
        """Take the tracked trocar's shift where the shaft is in that one alone, at its nearest."""
        before, self._beside, now = self._beside, None, measured.stamp
        if not measured.connected or self.tracked.objection(now) is not None:
            return False
        if self._trocar_pose(measured.position).is_outside:
            return False
        if self._off(self.noted.undone(measured).position, self._trocar) <= self._tolerance:
            return False
        shift, _ = self.tracked.shift(now)
        off = self._off(measured.position, self._trocar + shift)
        if before is None or off > self._tolerance or off < before:
            self._beside = off
            return False
        self.shift, (q, _) = shift, planning_joints(measured.position)
        self.noted.start(robot_joints(held_shift(self._model, q, self._trocar, shift), 0.0))
        return True

    def _off(self, joints: Vector, trocar: Vector) -> float:
        """Distance of the shaft from a trocar [m]."""
        return rcm_state(Configuration(self._model, planning_joints(joints)[0]), trocar).error

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Send a set-point, changed for the trocar as it is when the joints get there."""
        span = self.noted.span(setpoint.stamp)
        if span == 0.0:  # the stream begins anew, where the robot holds
            self._speed = np.zeros(3)
        self._go_on(setpoint.stamp, span)
        q, _ = planning_joints(setpoint.position)
        moved = robot_joints(shifted_joints(self._model, q, self._trocar, self.shift), 0.0)
        change = self.noted.add(setpoint.stamp, moved, span)
        self._sent = setpoint.position + moved
        velocity = setpoint.velocity + change.velocity
        self._robot.servo_jp(Setpoint(self._sent, velocity, setpoint.stamp))

    def hold(self) -> None:
        """Slow down and stay; the shift stays, too."""
        self._sent, self._speed = None, np.zeros(3)
        super().hold()

    def unfollowed(self, now: float) -> float:
        """How far the trocar is from where it is followed to [m]."""
        return float(np.linalg.norm(self.tracked.shift(now)[0] - self.shift))

    def _fault(self, now: float) -> str:
        """Why nothing may move; empty: all is well."""
        if words := self._frozen.objection:
            return Cause(Reason.SENSOR_FAULT, words).coded
        cause = self.tracked.objection(now) or self._behind(now) or self._in_no_trocar()
        return "" if cause is None else cause.coded

    def _behind(self, now: float) -> Cause | None:
        """Whether the trocar ran away from a shaft that had caught up with it."""
        gap, allowed = self.unfollowed(now), self._tolerance
        self._is_near = self._is_following and (self._is_near or gap < NEAR * allowed)
        if not self._is_near or gap <= allowed:
            return None
        words = f"shaft {gap * 1e3:.2f} mm behind the trocar that it follows"
        return Cause(Reason.TRACKER_TOO_FAR, f"{words}, allowed {allowed * 1e3:.2f} mm")

    def _in_no_trocar(self) -> Cause | None:
        """Whether the shaft that the robot holds is in the patient beside its trocar."""
        if self._beside is None:
            return None
        words = f"shaft held {self._beside * 1e3:.2f} mm off the tracked trocar"
        allowed = f"nothing moves before that is within {self._tolerance * 1e3:.2f} mm of it"
        return Cause(Reason.TRACKER_TOO_FAR, f"{words}; {allowed}")

    @property
    def _is_following(self) -> bool:
        return self._state() in ACTIVE_STATES

    def _go_on(self, now: float, span: float) -> None:
        """Move the shift on towards the trocar, within its limits, or let it come to rest."""
        wanted = np.zeros(3)
        if self._is_following and self.tracked.objection(now) is None:
            shift, speed = self.tracked.shift(now + self._lag)
            wanted = _within(speed + (shift - self.shift) / CATCH_UP, self._config.max_speed)
        change = _within(wanted - self._speed, self._config.max_acceleration * span)
        self._speed = self._speed + change
        self.shift = self.shift + span * self._speed


def _within(vector: Vector, most: float) -> Vector:
    """The vector, shortened to a length where it is longer."""
    length = float(np.linalg.norm(vector))
    return vector if length <= most else vector * (most / length)
