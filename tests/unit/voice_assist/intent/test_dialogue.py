# SPDX-License-Identifier: BSD-3-Clause
"""The voice mode and what is asked of the robot, after each word, answer and report."""

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
STOPPED = (Halt(), Call("stop"))


def after(state, phrase):
    return step(state, CommandRecognized(COMMANDS.get(phrase)))


@pytest.mark.parametrize("phrase", ["tense", "release", "pull more", "pull less", "terminate"])
def test_in_standby_these_do_nothing_and_say_why(phrase):
    outcome = after(AT_START, phrase)
    assert AT_START.mode is Mode.STANDBY and (outcome.state, outcome.actions) == (AT_START, ())
    words = f"{phrase!r} counts only in active mode, and the mode is standby"
    assert outcome.rejection == Rejection(RejectionReason.WRONG_MODE, words)


@pytest.mark.parametrize(
    ("state", "phrase", "mode", "actions"),
    [
        (AT_START, "hey robot", Mode.ACTIVE, (Call("hey robot"),)),
        (ACTIVE, "hey robot", Mode.ACTIVE, (Call("hey robot"),)),
        (ACTIVE, "tense", Mode.ACTIVE, (Call("tense"),)),
        (ACTIVE, "release", Mode.ACTIVE, (Call("release"),)),
        (ACTIVE, "pull more", Mode.ACTIVE, (Call("pull more"),)),
        (ACTIVE, "pull less", Mode.ACTIVE, (Call("pull less"),)),
        (AT_START, "stop", Mode.STANDBY, STOPPED),
        (ACTIVE, "stop", Mode.ACTIVE, STOPPED),
        (ACTIVE, "terminate", Mode.STANDBY, (Call("terminate"),)),
    ],
)
def test_a_word_is_passed_on_and_may_change_the_mode(state, phrase, mode, actions):
    outcome = after(state, phrase)
    is_new = mode is not state.mode
    assert outcome.state == (DialogueState(mode, phrase) if is_new else state)
    assert outcome.actions == (*actions, *([SetMode(mode, phrase)] if is_new else ()))
    assert outcome.rejection is None


def test_a_refused_activation_is_reported_and_does_not_change_the_mode():
    outcome = step(ACTIVE, Answered("hey robot", False, "the robot is moving"))
    words = "hey robot, refused by the robot: the robot is moving"
    assert outcome.state == DialogueState(Mode.ACTIVE, words)
    assert outcome.actions == (SetMode(Mode.ACTIVE, words),)


@pytest.mark.parametrize(
    ("state", "event"),
    [
        (ACTIVE, Answered("tense", False, "unreachable")),
        (ACTIVE, Answered("hey robot", True, "ready")),
        (ACTIVE, ModeReported(Mode.ACTIVE)),
        (AT_START, ModeReported(Mode.STANDBY)),
    ],
)
def test_other_answers_and_a_report_of_the_same_mode_change_nothing(state, event):
    outcome = step(state, event)
    assert (outcome.state, outcome.actions) == (state, ())


@pytest.mark.parametrize(("state", "mode"), [(AT_START, Mode.ACTIVE), (ACTIVE, Mode.STANDBY)])
def test_a_word_by_hand_changes_the_mode_of_the_voice_too(state, mode):
    outcome = step(state, ModeReported(mode))
    words = f"{mode.value} at the robot"
    assert outcome.state == DialogueState(mode, words)
    assert outcome.actions == (SetMode(mode, words),)
