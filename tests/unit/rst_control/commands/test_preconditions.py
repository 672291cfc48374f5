# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.commands.preconditions import Preconditions, mode_refusal
from rst_control.commands.request import Situation
from rst_control.commands.table import COMMANDS
from rst_control.kinematics.configuration import robot_joints
from rst_control.types import ControllerMode, Reason, State
from tests.unit.rst_control.support.situations import NOW, measurement, mode_of, situation

MOTIONS = [COMMANDS["tense"], COMMANDS["release"], COMMANDS["pull more"], COMMANDS["pull less"]]


@pytest.fixture
def conditions(planner):
    return Preconditions(planner)


def reason_of(refusal):
    return None if refusal is None else refusal.reason


@pytest.mark.parametrize("command", MOTIONS)
def test_once_halted_nothing_moves_and_the_reason_is_named(joints, command):
    refusal = mode_refusal(command, situation(joints, halt_reason='"stop" was said').mode)
    assert refusal.reason is Reason.HALTED
    assert '"stop" was said' in refusal.words
    assert "hey robot" in refusal.words


@pytest.mark.parametrize("command", MOTIONS)
def test_a_robot_that_never_spoke_or_was_lost_is_named(conditions, joints, command):
    silent = Situation(measurement=None, now=NOW, mode=mode_of())
    assert reason_of(conditions.refusal(command, silent)) is Reason.NOT_CONNECTED
    lost = situation(joints, connected=False)
    assert reason_of(conditions.refusal(command, lost)) is Reason.NOT_CONNECTED


def test_stale_joint_states_are_refused_with_their_age(conditions, joints):
    assert conditions.refusal(COMMANDS["tense"], situation(joints, age=0.019)) is None
    refusal = conditions.refusal(COMMANDS["tense"], situation(joints, age=0.035))
    assert refusal.reason is Reason.STALE
    assert "35 ms" in refusal.words
    assert "allowed 20 ms" in refusal.words


def test_a_fault_is_reported_in_its_own_words(conditions, joints):
    refusal = conditions.refusal(COMMANDS["tense"], situation(joints, fault="joint_4 blocked"))
    assert refusal.reason is Reason.FAULTED
    assert "joint_4 blocked" in refusal.words


@pytest.mark.parametrize("command", MOTIONS)
def test_while_the_robot_brakes_to_be_active_again_a_motion_waits_until_it_rests(command):
    braking = ControllerMode(State.STOPPING, is_active=True, mode_after=State.ACTIVE)
    refusal = mode_refusal(command, braking)
    assert refusal.reason is Reason.NOT_AT_REST
    assert "braking" in refusal.words
    assert mode_refusal(command, replace(braking, state=State.ACTIVE)) is None


def test_a_shaft_measured_off_the_trocar_is_refused_with_the_distance(conditions, home):
    off = home + 0.01 * np.eye(9)[3]
    refusal = conditions.refusal(COMMANDS["tense"], situation(robot_joints(off, 0.0)))
    assert refusal.reason is Reason.RCM_TOLERANCE
    assert "allowed 1000.00 um" in refusal.words


def test_jaws_that_hold_tissue_may_be_opened_with_the_shaft_off_the_trocar(conditions, home):
    off = home + 0.01 * np.eye(9)[3]
    holding = situation(robot_joints(off, 0.0), gripped=True)
    assert conditions.refusal(COMMANDS["release"], holding) is None
    for words in ("pull more", "pull less"):
        assert reason_of(conditions.refusal(COMMANDS[words], holding)) is Reason.RCM_TOLERANCE
    empty = situation(robot_joints(off, 0.0))
    assert reason_of(conditions.refusal(COMMANDS["release"], empty)) is Reason.RCM_TOLERANCE


def test_tension_of_a_measurement_is_the_length_of_the_force(joints):
    measured = measurement(joints, tension=1.5)
    assert measured.tension == pytest.approx(1.5)
    assert not measured.position.flags.writeable
    with pytest.raises(ValueError, match="not finite"):
        measurement(np.full(10, np.nan))


def test_a_command_of_standby_alone_is_refused_once_active():
    only = replace(COMMANDS["tense"], counts_in=frozenset({State.STANDBY}))
    assert mode_refusal(only, mode_of()).reason is Reason.WRONG_MODE
    assert mode_refusal(only, mode_of(is_active=False)) is None
