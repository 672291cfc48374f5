# SPDX-License-Identifier: BSD-3-Clause
"""What must hold before a command is planned: the controller's mode and the robot's health."""

from __future__ import annotations

from typing import Final

import numpy as np

from rst_control.configuration import Configuration, planning_joints
from rst_control.errors import TrocarDrift
from rst_control.planner import Planner
from rst_control.rcm import rcm_state
from rst_control.types import JOINTS, Command, Measurement, Reason, Rejected, Situation

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


class Conditions:
    """Checks what the robot side last said.

    Args:
        planner: Knows the robot, the trocar and the settings.
    """

    def __init__(self, planner: Planner) -> None:
        self._model, self._trocar = planner.model, planner.trocar
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
            return Rejected(Reason.FAULTED, f"robot fault: {measured.fault}")
        if command is not Command.HEY_ROBOT:
            return self._shaft(measured)
        is_under_way = situation.is_moving and situation.is_active and not situation.halt_reason
        return None if is_under_way else self._rest(measured)

    def _rest(self, measured: Measurement) -> Rejected | None:
        speeds, allowed = np.abs(measured.velocity), self._watchdogs.at_rest_speed
        worst = int(speeds.argmax())
        if speeds[worst] <= allowed:
            return None
        words = f"not at rest: {JOINTS[worst]} at {speeds[worst]:.3f} rad/s, allowed {allowed:.3f}"
        return Rejected(Reason.NOT_AT_REST, words)

    def _shaft(self, measured: Measurement) -> Rejected | None:
        q, _ = planning_joints(measured.position)
        error = rcm_state(Configuration(self._model, q), self._trocar).error
        if error <= self._shaft_tolerance:
            return None
        drift = TrocarDrift(error, self._shaft_tolerance)
        return Rejected(Reason.RCM_TOLERANCE, f"measured: {drift}")
