# SPDX-License-Identifier: BSD-3-Clause
"""The arm as CRTK sees it: four states, pose and twist of the tip, and which words do what."""

import numpy as np
import pytest

from rst_control.commands.table import COMMANDS as ROBOT_COMMANDS
from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.robot.crtk import COMMANDS, measured_tip, operating_state, state_command
from rst_control.types import State

RNG = np.random.default_rng(3)


@pytest.mark.parametrize(
    ("state", "is_enabled", "found"),
    [
        (State.STANDBY, False, ("DISABLED", False)),
        (State.ACTIVE, True, ("ENABLED", False)),
        (State.MOVING, True, ("ENABLED", True)),
        (State.STOPPING, True, ("PAUSED", True)),
        (State.STOPPING, False, ("DISABLED", True)),
        (State.HALTED, True, ("PAUSED", False)),
        (State.HALTED, False, ("DISABLED", False)),
        (State.FAULTED, True, ("FAULT", False)),
    ],
)
def test_the_controllers_state_is_one_of_four(state, is_enabled, found):
    shown = operating_state(state.value, is_enabled, is_measured=True)
    assert (shown.state, shown.is_busy, shown.is_homed) == (*found, True)


def test_every_state_of_the_controller_is_shown():
    for state in State:
        for is_enabled in (False, True):
            assert operating_state(state.value, is_enabled, True).state in (
                *("DISABLED", "ENABLED", "PAUSED", "FAULT"),
            )


@pytest.mark.parametrize(("state", "is_measured"), [("", True), ("active", False)])
def test_a_silent_controller_and_joints_that_are_not_measured_are_a_fault(state, is_measured):
    shown = operating_state(state, True, is_measured)
    assert (shown.state, shown.is_homed) == ("FAULT", is_measured)


def test_pause_and_disable_brake_and_all_else_is_a_command_of_any_caller_or_refused():
    assert {word for word, follows in COMMANDS.items() if follows.brakes} == {"pause", "disable"}
    for follows in COMMANDS.values():
        assert not follows.command or follows.command in ROBOT_COMMANDS
        assert bool(follows.refusal) is not (follows.brakes or bool(follows.command))
    assert {f.command for f in COMMANDS.values()} <= {"", "hey robot", "terminate"}  # no motion


@pytest.mark.parametrize("word", ["home", "unhome", "HOME ", "tense", "", "x" * 1000])
def test_home_and_unknown_words_are_refused_by_name(word):
    follows = state_command(word)
    assert follows.refusal and not follows.brakes and not follows.command
    assert word.strip().lower()[:40] in follows.refusal and len(follows.refusal) < 200


def test_the_pose_is_that_of_the_tip_and_the_twist_its_derivative():
    model = load_robot()
    joints, speeds = RNG.uniform(-1.0, 1.0, 10), RNG.uniform(-0.5, 0.5, 10)
    pose, twist = measured_tip(model, joints, speeds)
    assert pose == pytest.approx(Configuration(model, planning_joints(joints)[0]).T_base_tip)
    dt = 1e-6
    later, _ = measured_tip(model, joints + dt * speeds, speeds)
    assert (later[:3, 3] - pose[:3, 3]) / dt == pytest.approx(twist[:3], abs=1e-5)
    turn = (later[:3, :3] @ pose[:3, :3].T - np.eye(3)) / dt
    spin = np.array([turn[2, 1], turn[0, 2], turn[1, 0]])
    assert spin == pytest.approx(twist[3:], abs=1e-5)
