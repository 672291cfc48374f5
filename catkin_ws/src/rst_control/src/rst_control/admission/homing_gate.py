# SPDX-License-Identifier: BSD-3-Clause
"""Whether the tool may be homed: its wrist and jaws then move over their whole range.

The bridge asks before it homes the tool. It homes nothing without an answer.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from rst_control.admission.first_motion_gate import VALID_FOR
from rst_control.config import ControllerConfig
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.kinematics.configuration import planning_joints
from rst_control.planning.patient_surface import Patient
from rst_control.robot.health import joint_in_motion
from rst_control.types import Measurement

ASK: Final = (
    "dry run: homing moves wrist and jaws over their whole range, {reach:.0f} mm around the wrist. "
    "Look that nothing is there, call rst_control/confirm, then robot/home_tool again"
)


class HomingGate:
    """Decides whether the tool may be homed; from any thread.

    Args:
        config: Where it may be homed, and whether a first motion is confirmed.
        patient: The surface of the active trocar.
        clock: Time [s], that of the measurements.
    """

    def __init__(
        self,
        config: ControllerConfig,
        patient: Callable[[], Patient],
        clock: Callable[[], float],
    ) -> None:
        self._config, self._patient, self._clock = config, patient, clock
        self._asked = self._confirmed = -VALID_FOR  # [s] when

    def refusal(self, view: ControllerSnapshot) -> str:
        """Why the tool may not be homed now; empty: it may."""
        refusal = self._unsafe(view)
        if refusal or self._config.first_motion == "free":
            self.forget()
            return refusal
        if self._clock() - self._confirmed < VALID_FOR:
            self._confirmed = -VALID_FOR
            return ""
        self._asked = self._clock()
        return ASK.format(reach=self._patient().sweep * 1e3)

    def confirm(self) -> bool:
        """Let the homing that was asked for begin when it is asked for again; False: none was."""
        was_asked = self._clock() - self._asked < VALID_FOR
        self.forget()
        if was_asked:
            self._confirmed = self._clock()
        return was_asked

    def forget(self) -> None:
        """What was asked for is confirmed no more: something else is shown now."""
        self._asked = -VALID_FOR

    def _unsafe(self, view: ControllerSnapshot) -> str:
        measured, watchdogs = view.measurement, self._config.watchdogs
        if measured is None or not measured.connected:
            return "where the tool is, is not known: the robot is not connected"
        age = self._clock() - measured.stamp
        if age > watchdogs.joint_state_age:
            return f"where the tool is, is not known: joint states {age:.2f} s old"
        if view.mode.is_active or view.is_moving:
            return f'the assistance is active ({view.mode.state.value}): say "terminate" first'
        if measured.gripped:
            return "the jaws hold tissue: release it first"
        moves = joint_in_motion(measured, watchdogs.at_rest_speed)
        return moves.words if moves is not None else self._inside(measured)

    def _inside(self, measured: Measurement) -> str:
        if self._config.homing == "anywhere":
            return ""
        patient = self._patient()
        height, needed = patient.wrist_height(planning_joints(measured.position)[0]), patient.sweep
        if height >= needed:
            return ""
        return (
            f"the tool is in the patient, or too near: wrist {height * 1e3:.0f} mm above the "
            f"surface, at least {needed * 1e3:.0f} mm needed; withdraw it first"
        )
