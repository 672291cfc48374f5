# SPDX-License-Identifier: BSD-3-Clause
"""The first motion is shown, refused, confirmed and only then carried out; later ones are free."""

import numpy as np
import pytest

from rst_control.admission.command_queue import CommandQueue
from rst_control.admission.first_motion_gate import VALID_FOR, FirstMotion
from rst_control.commands.request import Accepted, Plan, Situation
from rst_control.commands.table import COMMANDS
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.types import Measurement, Reason, Rejected
from tests.unit.rst_control.support.executor_rig import Rig
from tests.unit.rst_control.support.situations import mode_of, request

STILL = np.zeros(10)


def at(position, now=0.0):
    return Situation(Measurement(position, STILL, STILL, now), now, mode=mode_of())


def verify(request, situation):
    command = request.command
    if command is COMMANDS["withdraw"]:
        return Rejected(Reason.ALREADY_THERE, "outside already")
    phases = (Phase(PhaseKind.OPEN, opening=0.5),) if command in MOVING else ()
    return Accepted(Plan(command, "does it", phases))


MOVING = (COMMANDS["tense"], COMMANDS["release"], COMMANDS["pull more"])


class Asked:
    def __init__(self):
        self.now, self.shown, self.context = 0.0, [], object()
        self.first = FirstMotion(verify, self.shown.append, lambda: self.now, lambda: self.context)

    def say(self, words, position=STILL):
        return self.first(request(words), at(position))

    def confirm(self):
        """Let a motion be shown and confirmed."""
        self.say("tense")
        return self.first.confirm()

    def set_off(self, words):
        decision = self.say(words)
        assert isinstance(decision, Accepted)
        decision.started()


@pytest.fixture
def asked():
    return Asked()


def test_the_first_motion_is_shown_and_refused_as_often_as_it_is_said(asked):
    for _ in range(3):
        answer = asked.say("tense")
        assert answer.reason is Reason.NOT_CONFIRMED
        assert "rst_control/confirm" in answer.words
    assert [plan.command for plan in asked.shown] == [COMMANDS["tense"]] * 3


def test_what_moves_nothing_is_never_asked_about(asked):
    for words in ("hey robot", "stop", "terminate"):
        assert isinstance(asked.say(words), Accepted)
    assert asked.shown == []


def test_what_is_refused_anyway_keeps_its_reason(asked):
    assert asked.say("withdraw").reason is Reason.ALREADY_THERE
    assert asked.shown == []


def test_confirmed_it_goes_and_nothing_asks_any_more(asked):
    assert asked.confirm().accepted
    asked.set_off("tense")
    assert isinstance(asked.say("release", STILL + 1.0), Accepted)
    assert isinstance(asked.say("tense", STILL + 2.0), Accepted)
    assert [plan is None for plan in asked.shown] == [False, True]
    assert not asked.first.confirm().accepted


def test_until_what_was_confirmed_has_set_off_it_alone_may_come_again(asked):
    asked.confirm()
    assert isinstance(asked.say("tense"), Accepted)
    assert isinstance(asked.say("tense"), Accepted)  # verified again: the situation had changed
    assert None not in asked.shown
    assert asked.say("release").reason is Reason.NOT_CONFIRMED
    assert asked.say("tense").reason is Reason.NOT_CONFIRMED
    assert asked.first.confirm().accepted


def test_what_was_confirmed_is_shown_again_where_the_trocar_changes_before_it_sets_off(asked):
    asked.confirm()
    assert isinstance(asked.say("tense"), Accepted)
    asked.context = object()
    assert asked.say("tense").reason is Reason.NOT_CONFIRMED


@pytest.mark.parametrize("is_stopped", [True, False])
def test_a_confirmed_motion_that_a_stop_outruns_frees_no_other(is_stopped):
    rig = Rig().awake()
    first = FirstMotion(rig.context.verify, lambda plan: None, lambda: rig.now, lambda: rig.context)
    rig.queue = CommandQueue(rig.executor, first, lambda: rig.now)
    assert "dry run" in rig.refused("tense")
    assert first.confirm().accepted
    pending = rig.verified()
    if is_stopped:
        rig.queue.take("stop", "test")
    rig.run(0.01)
    assert pending.reply.result(0).accepted is not is_stopped
    rig.say("stop")
    rig.rest()
    rig.say("hey robot")
    if is_stopped:
        assert "dry run" in rig.refused("withdraw")
    else:
        rig.say("withdraw")


def test_nothing_can_be_confirmed_before_it_was_shown(asked):
    reply = asked.first.confirm()
    assert not reply.accepted
    assert "no path was shown" in reply.message
    assert isinstance(asked.say("tense"), Rejected)


def test_another_command_than_the_one_shown_is_shown_first(asked):
    asked.confirm()
    assert isinstance(asked.say("release"), Rejected)
    assert isinstance(asked.say("tense"), Rejected)  # the confirmation was for what was shown then
    asked.first.confirm()
    assert isinstance(asked.say("tense"), Accepted)


def test_another_place_than_where_it_was_shown_is_shown_first(asked):
    asked.confirm()
    moved = STILL.copy()
    moved[3] = 0.01
    assert isinstance(asked.say("tense", moved), Rejected)


def test_with_another_trocar_or_grasp_point_the_path_is_shown_again(asked):
    asked.confirm()
    asked.context = object()
    assert asked.say("tense").reason is Reason.NOT_CONFIRMED
    assert len(asked.shown) == 2
    asked.first.confirm()
    assert isinstance(asked.say("tense"), Accepted)


def test_a_confirmation_does_not_hold_for_ever(asked):
    asked.confirm()
    asked.now = VALID_FOR + 1.0
    assert isinstance(asked.say("tense"), Rejected)
