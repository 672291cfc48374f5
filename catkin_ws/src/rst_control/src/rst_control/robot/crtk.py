# SPDX-License-Identifier: BSD-3-Clause
"""The arm in the words of the Collaborative Robotics Toolkit (CRTK, Robot API of 2019).

Its four states are DISABLED, ENABLED, PAUSED and FAULT. Its commands become those that any caller
may give, so each is verified or refused as ever.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from rst_control.kinematics.configuration import Array, Configuration, planning_joints
from rst_control.kinematics.robot_model import RobotModel
from rst_control.types import State, Vector

DISABLED, ENABLED, PAUSED, FAULT = "DISABLED", "ENABLED", "PAUSED", "FAULT"


@dataclass(frozen=True)
class OperatingState:
    """What CRTK's `operating_state` says."""

    state: str
    is_homed: bool
    is_busy: bool


@dataclass(frozen=True)
class StateCommand:
    """What follows from a word on CRTK's `state_command`."""

    brakes: bool = False  # at once, by the stop topic
    command: str = ""  # for the controller, as from any caller; empty: none
    refusal: str = ""  # why nothing follows; empty: something does


COMMANDS: Final = {
    "enable": StateCommand(command="hey robot"),
    "resume": StateCommand(command="hey robot"),
    "pause": StateCommand(brakes=True),
    "disable": StateCommand(brakes=True, command="terminate"),
    "home": StateCommand(refusal="home: refused; the arm needs none, the tool is homed by hand"),
    "unhome": StateCommand(refusal="unhome: refused; the arm's joints are always known"),
}


def operating_state(state: str, is_enabled: bool, is_measured: bool) -> OperatingState:
    """CRTK's state of the controller's.

    Args:
        state: `ControllerState.state`; empty where the controller is silent.
        is_enabled: `ControllerState.assistance_enabled`.
        is_measured: All joints are measured now.

    Returns:
        FAULT also where the controller is silent or joints are not measured.
    """
    is_busy = state in (State.MOVING.value, State.STOPPING.value)
    if not state or state == State.FAULTED.value or not is_measured:
        return OperatingState(FAULT, is_measured, is_busy)
    if not is_enabled:
        return OperatingState(DISABLED, is_measured, is_busy)
    is_paused = state in (State.HALTED.value, State.STOPPING.value)
    return OperatingState(PAUSED if is_paused else ENABLED, is_measured, is_busy)


def state_command(word: str) -> StateCommand:
    """What follows from a word; one that is none is refused with those that are."""
    unknown = f"{word[:40]!r}: unknown, allowed: {', '.join(COMMANDS)}"
    return COMMANDS.get(word.strip().lower(), StateCommand(refusal=unknown))


def measured_tip(model: RobotModel, joints: Vector, speeds: Vector) -> tuple[Array, Vector]:
    """Pose and twist of the tool's tip in base_link, CRTK's `measured_cp` and `measured_cv`.

    Args:
        model: The robot.
        joints: In the order of `types.JOINTS` [rad]. Shape (10,).
        speeds: Of the same [rad/s]. Shape (10,).

    Returns:
        Pose, shape (4, 4) [m]; twist, linear [m/s] before angular [rad/s], shape (6,).
    """
    configuration = Configuration(model, planning_joints(joints)[0])
    return configuration.T_base_tip, configuration.J_tip @ planning_joints(speeds)[0]
