# SPDX-License-Identifier: BSD-3-Clause
import pytest

from voice_assist.config import load_voice_config
from voice_assist.intent.dialogue import (
    AT_START,
    Answered,
    CommandRecognized,
    DialogueState,
    ModeReported,
    step,
)
from voice_assist.types import Call, Halt, Mode, Rejection, RejectionReason, SetMode

COMMANDS = load_voice_config().commands
ACTIVE = DialogueState(Mode.ACTIVE, "hey robot")


def after(state, phrase):
    return step(state, CommandRecognized(COMMANDS.get(phrase)))


def test_it_starts_in_standby():
    assert AT_START.mode is Mode.STANDBY


@pytest.mark.parametrize("phrase", ["tense", "release", "pull more", "pull less", "terminate"])
def test_in_standby_these_do_nothing_and_say_why(phrase):
    outcome = after(AT_START, phrase)
    assert outcome.state == AT_START
    assert outcome.actions == ()
    words = f"{phrase!r} counts only in active mode, and the mode is standby"
    assert outcome.rejection == Rejection(RejectionReason.WRONG_MODE, words)


def test_hey_robot_activates_from_standby():
    outcome = after(AT_START, "hey robot")
    assert outcome.state.mode is Mode.ACTIVE
    assert outcome.actions == (Call("hey robot"), SetMode(Mode.ACTIVE, "hey robot"))


def test_hey_robot_in_active_mode_is_passed_on():
    outcome = after(ACTIVE, "hey robot")
    assert outcome.state == ACTIVE
    assert outcome.actions == (Call("hey robot"),)


@pytest.mark.parametrize("phrase", ["tense", "release", "pull more", "pull less"])
def test_in_active_mode_motions_are_called(phrase):
    outcome = after(ACTIVE, phrase)
    assert outcome.state == ACTIVE
    assert outcome.actions == (Call(phrase),)


@pytest.mark.parametrize("state", [AT_START, ACTIVE])
def test_stop_halts_first_and_then_calls_in_any_mode(state):
    outcome = after(state, "stop")
    assert outcome.actions == (Halt(), Call("stop"))
    assert outcome.state == state


def test_terminate_goes_to_standby():
    outcome = after(ACTIVE, "terminate")
    assert outcome.state.mode is Mode.STANDBY
    assert outcome.actions == (Call("terminate"), SetMode(Mode.STANDBY, "terminate"))


def test_a_refused_activation_is_told_and_does_not_change_the_mode():
    active = after(AT_START, "hey robot").state
    outcome = step(active, Answered("hey robot", False, "the robot is moving"))
    assert outcome.state.mode is Mode.ACTIVE
    (told,) = outcome.actions
    assert told == SetMode(Mode.ACTIVE, "hey robot, refused by the robot: the robot is moving")


def test_a_refused_motion_leaves_the_mode_alone():
    outcome = step(ACTIVE, Answered("tense", False, "unreachable"))
    assert outcome.state == ACTIVE
    assert outcome.actions == ()


def test_an_accepted_call_changes_nothing():
    outcome = step(ACTIVE, Answered("tense", True, "tensing"))
    assert (outcome.state, outcome.actions) == (ACTIVE, ())


def test_hey_robot_by_hand_activates_the_voice_too():
    outcome = step(AT_START, ModeReported(Mode.ACTIVE))
    assert outcome.state.mode is Mode.ACTIVE
    assert outcome.actions == (SetMode(Mode.ACTIVE, "active at the robot"),)
    assert after(outcome.state, "tense").actions == (Call("tense"),)


def test_terminate_by_hand_puts_the_voice_into_standby():
    outcome = step(ACTIVE, ModeReported(Mode.STANDBY))
    assert outcome.actions == (SetMode(Mode.STANDBY, "standby at the robot"),)
    assert after(outcome.state, "tense").actions == ()


@pytest.mark.parametrize("state", [AT_START, ACTIVE])
def test_a_report_of_the_same_mode_changes_nothing(state):
    outcome = step(state, ModeReported(state.mode))
    assert (outcome.state, outcome.actions) == (state, ())
