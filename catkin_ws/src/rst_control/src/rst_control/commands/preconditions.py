# SPDX-License-Identifier: BSD-3-Clause
"""What must hold before a command is planned: the controller's mode and the robot's state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rst_control.commands.request import Situation
from rst_control.commands.spec import CommandSpec, Place, Role, TissueNeeded
from rst_control.errors import InsertionOutOfRange, TrocarDrift
from rst_control.robot.health import robot_unfit
from rst_control.types import NOT_CONNECTED, ControllerMode, Measurement, Reason, Rejected, State

if TYPE_CHECKING:
    from rst_control.planning.patient_surface import TrocarPose
    from rst_control.planning.planner import Planner


def mode_refusal(command: CommandSpec, mode: ControllerMode) -> Rejected | None:
    """Why the controller's mode forbids a command; None where it counts.

    The verifier asks before planning. The executor asks again when the motion would begin.
    """
    if mode.state in command.counts_in:
        return None
    match mode.state:
        case State.STANDBY:
            return Rejected(Reason.WRONG_MODE, 'in standby; say "hey robot" first')
        case State.ACTIVE:
            return Rejected(Reason.WRONG_MODE, "active already")
        case State.MOVING:
            return Rejected(Reason.BUSY, 'busy moving; wait, or say "stop"')
        case State.STOPPING if command.role is Role.ACTIVATE:
            return Rejected(Reason.NOT_AT_REST, "still braking; say it again at rest")
        case State.STOPPING if not mode.is_latched:
            return Rejected(Reason.NOT_AT_REST, "braking; wait until the robot is at rest")
    return Rejected(Reason.HALTED, f'halted ({mode.reason}); say "hey robot" to go on')


class Preconditions:
    """Checks the robot's newest measurement against what a command needs.

    Args:
        planner: Knows the robot, the trocar and the settings.
    """

    def __init__(self, planner: Planner) -> None:
        self._patient, self._insertion = planner.patient, planner.config.rcm.insertion
        self._max_age = planner.config.controller.watchdogs.joint_state_age
        self._shaft_tolerance = planner.config.rcm.measured_tolerance

    def refusal(self, command: CommandSpec, situation: Situation) -> Rejected | None:
        """Why the robot's state forbids a command; None where it does not."""
        measured = situation.measurement
        unfit = robot_unfit(measured, situation.now, self._max_age)
        if unfit is not None or measured is None:
            return Rejected.by(unfit or NOT_CONNECTED)
        return self._place(command, measured) or _tissue(command, measured)

    def _place(self, command: CommandSpec, measured: Measurement) -> Rejected | None:
        """Whether the tool is where the command begins."""
        from rst_control.kinematics.configuration import planning_joints

        q, _ = planning_joints(measured.position)
        place = self._patient.trocar_pose(q)
        if command.place is Place.INSIDE_OR_HOLDING and measured.gripped:
            return None  # its plan moves no arm whose shaft is off the trocar
        if is_off_trocar(place, self._shaft_tolerance):
            drift = TrocarDrift(place.error, self._shaft_tolerance)
            return Rejected(Reason.RCM_TOLERANCE, f"measured: {drift}")
        if command.place is Place.ANYWHERE:
            return None
        if place.is_outside:
            words = f"tool not inserted: tip {-place.insertion * 1e3:.1f} mm outside the trocar"
            return Rejected(Reason.NOT_INSERTED, f'{words}, allowed inside; "insert" first')
        minimum, maximum = self._insertion
        if place.wrist < minimum and not measured.gripped:
            shallow = InsertionOutOfRange(place.wrist, minimum, maximum)
            return Rejected(Reason.INSERTION_DEPTH, f'{shallow}; "insert" first')
        return None


def is_off_trocar(place: TrocarPose, tolerance: float) -> bool:
    """Whether the shaft is further from the trocar than a tolerance [m], the robot not outside."""
    return not place.is_outside and not place.error <= tolerance


def _tissue(command: CommandSpec, measured: Measurement) -> Rejected | None:
    """Whether the jaws hold what the command needs them to hold."""
    if command.tissue is TissueNeeded.HELD and not measured.gripped:
        words = f'nothing grasped; "{command.phrase}" needs tissue between the jaws'
        return Rejected(Reason.NOTHING_GRASPED, words)
    if command.tissue is TissueNeeded.NONE and measured.gripped:
        words = f'tissue held at {measured.tension:.2f} N, "{command.phrase}" needs empty jaws'
        return Rejected(Reason.ALREADY_GRASPED, f"{words}; release first")
    return None
