# SPDX-License-Identifier: BSD-3-Clause
"""What must hold before a command is planned: the controller's mode and the robot's health."""

from __future__ import annotations

from typing import Final

import numpy as np

from rst_control.errors import InsertionOutOfRange, TrocarDrift
from rst_control.kinematics.configuration import planning_joints
from rst_control.planning.patient_surface import TrocarPose
from rst_control.planning.plan import Rejected, Situation
from rst_control.planning.planner import Planner
from rst_control.types import BY_HAND, JOINTS, Command, Measurement, Reason, robot_fault

PULLS: Final = (Command.PULL_MORE, Command.PULL_LESS)


def mode_refusal(command: Command, situation: Situation) -> Rejected | None:
    """Why the controller's mode forbids a command; None where it does not."""
    if command in (Command.STOP, Command.HEY_ROBOT):
        return None
    if not situation.is_active and not situation.halt_reason:
        return Rejected(Reason.WRONG_MODE, 'in standby; say "hey robot" first')
    if command is Command.TERMINATE:
        return None
    if situation.halt_reason:
        words = f'halted ({situation.halt_reason}); say "hey robot" to go on'
        return Rejected(Reason.HALTED, words)
    if situation.is_moving and command not in PULLS:
        return Rejected(Reason.BUSY, 'busy moving; wait, or say "stop"')
    return None


def rest_refusal(measured: Measurement, allowed: float) -> Rejected | None:
    """Which joint moves faster than allowed [rad/s]; None where all are at rest."""
    speeds = np.abs(measured.velocity)
    worst = int(speeds.argmax())
    if speeds[worst] <= allowed:
        return None
    words = f"not at rest: {JOINTS[worst]} at {speeds[worst]:.3f} rad/s, allowed {allowed:.3f}"
    return Rejected(Reason.NOT_AT_REST, words)


class Conditions:
    """Checks what the robot side last said.

    Args:
        planner: Knows the robot, the trocar and the settings.
    """

    def __init__(self, planner: Planner) -> None:
        self._patient, (self._least, self._most) = planner.patient, planner.config.rcm.insertion
        self._watchdogs = planner.config.controller.watchdogs
        self._shaft_tolerance = planner.config.rcm.measured_tolerance

    def refusal(self, command: Command, situation: Situation) -> Rejected | None:
        """Why the robot's state forbids a command; None where it does not."""
        if command in (Command.STOP, Command.TERMINATE):
            return None
        measured = situation.measurement
        if measured is None or not measured.connected:
            return Rejected(Reason.NOT_CONNECTED, "robot not connected")
        age, allowed = situation.now - measured.stamp, self._watchdogs.joint_state_age
        if age > allowed:
            words = f"joint states {age * 1e3:.0f} ms old, allowed {allowed * 1e3:.0f} ms"
            return Rejected(Reason.STALE, words)
        if measured.fault:
            fault = robot_fault(measured.fault)
            return Rejected(fault.reason, f"robot fault: {fault.words}")
        if command is not Command.HEY_ROBOT:
            return self._placed(command, measured)
        is_under_way = situation.is_moving and situation.is_active and not situation.halt_reason
        return None if is_under_way else rest_refusal(measured, self._watchdogs.at_rest_speed)

    def _placed(self, command: Command, measured: Measurement) -> Rejected | None:
        """Whether the tool is where the command begins: outside, in the trocar or inside."""
        q, _ = planning_joints(measured.position)
        place = self._patient.trocar_pose(q)
        if command is Command.RELEASE and measured.gripped and place.is_outside:
            return None  # to open the jaws is never wrong
        if not place.is_outside and not place.error <= self._shaft_tolerance:
            drift = TrocarDrift(place.error, self._shaft_tolerance)
            return Rejected(Reason.RCM_TOLERANCE, f"measured: {drift}")
        if command in BY_HAND:
            return _already(command, place, self._least)
        if place.is_outside:
            words = f"tool not inserted: tip {-place.insertion * 1e3:.1f} mm outside the trocar"
            return Rejected(Reason.NOT_INSERTED, f'{words}, allowed inside; "insert" first')
        if place.wrist < self._least and not measured.gripped:
            shallow = InsertionOutOfRange(place.wrist, self._least, self._most)
            return Rejected(Reason.INSERTION_DEPTH, f'{shallow}; "insert" first')
        return None


def _already(command: Command, place: TrocarPose, least: float) -> Rejected | None:
    """Whether there is nothing left to insert or withdraw."""
    if command is Command.WITHDRAW and place.is_outside:
        words = f"already outside: tip {-place.insertion * 1e3:.1f} mm outside the trocar"
        return Rejected(Reason.ALREADY_THERE, words)
    if command is Command.INSERT and place.wrist >= least and not place.is_outside:
        words = f"already inserted: {place.wrist * 1e3:.1f} mm of shaft inside the trocar"
        return Rejected(Reason.ALREADY_THERE, words)
    return None
