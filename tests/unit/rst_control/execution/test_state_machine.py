# SPDX-License-Identifier: BSD-3-Clause
from itertools import product

import pytest

from rst_control.execution import state_machine
from rst_control.execution.state_machine import LATCHED, Life, State
from rst_control.types import Command, Reason

MOTIONS = (Command.TENSE, Command.RELEASE, Command.PULL_MORE, Command.PULL_LESS)


def commanded(life, command):
    """What the executor makes of a command where the robot is healthy and all is verified."""
    if state_machine.refusal(life, command) is not None:
        return life
    if command is Command.HEY_ROBOT:
        return state_machine.activated(life)
    if command is Command.STOP:
        return state_machine.stopped(life, "stop")
    if command is Command.TERMINATE:
        return state_machine.terminated(life)
    return state_machine.started(life)


EVENTS = {
    **{c.value: (lambda life, c=c: commanded(life, c)) for c in (*Command,)},
    "fault": lambda life: state_machine.faulted(life, "fault"),
    "failure": state_machine.failed,
    "rest": state_machine.at_rest,
}


def reachable():
    """Every life that any sequence of events leads to, with the events that led there."""
    found, edge = {Life(): ()}, [Life()]
    while edge:
        life = edge.pop()
        for name, event in EVENTS.items():
            after = event(life)
            if after not in found:
                found[after] = (*found[life], name)
                edge.append(after)
    return found


LIVES = reachable()


def test_every_state_can_be_reached_and_there_are_few_lives():
    assert {life.state for life in LIVES} == set(State)
    assert len(LIVES) < 100


@pytest.mark.parametrize("command", MOTIONS)
def test_no_motion_starts_but_from_active_or_by_a_pull_that_takes_over(command):
    for life, way in LIVES.items():
        if state_machine.refusal(life, command) is None:
            takes_over = life.state is State.MOVING and command in state_machine.RETARGETS
            assert life.state is State.ACTIVE or takes_over, way
            assert life.is_active and not life.is_latched, way


def test_only_hey_robot_clears_a_latch():
    for life, (name, event) in product(LIVES, EVENTS.items()):
        if life.is_latched and not event(life).is_latched:
            assert name == "hey robot" and life.state in LATCHED


def test_only_hey_robot_activates_and_only_terminate_ends_it():
    for life, (name, event) in product(LIVES, EVENTS.items()):
        after = event(life)
        if after.is_active != life.is_active:
            assert name == ("hey robot" if after.is_active else "terminate")


def test_stop_is_allowed_everywhere_and_leads_to_rest_and_a_latch():
    for life in LIVES:
        assert state_machine.refusal(life, Command.STOP) is None
        after = state_machine.stopped(life, "stop")
        assert after.is_latched and after.state is not State.MOVING
        assert state_machine.at_rest(after).state in LATCHED


def test_a_fault_in_motion_latches_whatever_else_was_going_on():
    for life in LIVES:
        if life.state in state_machine.IN_MOTION:
            assert state_machine.at_rest(state_machine.faulted(life, "x")).state is State.FAULTED


def test_after_terminate_only_hey_robot_and_stop_are_heard_until_hey_robot():
    for life in LIVES:
        if state_machine.refusal(life, Command.TERMINATE) is None:
            after = state_machine.terminated(life)
            for command in MOTIONS:
                assert state_machine.refusal(after, command) is not None
            assert not after.is_active


def test_refusals_name_their_reason():
    def reason(life):
        return state_machine.refusal(life, Command.TENSE).reason

    assert reason(Life()) is Reason.WRONG_MODE
    moving = state_machine.started(state_machine.activated(Life()))
    assert reason(moving) is Reason.BUSY
    assert reason(state_machine.terminated(moving)) is Reason.NOT_AT_REST
    assert reason(state_machine.stopped(moving, "x")) is Reason.HALTED
    assert reason(state_machine.faulted(moving, "x")) is Reason.FAULTED


def test_the_first_cause_of_a_halt_is_the_one_that_is_told():
    moving = state_machine.started(state_machine.activated(Life()))
    life = state_machine.stopped(state_machine.faulted(moving, "tension over its limit"), "stop")
    assert state_machine.at_rest(life).reason == "tension over its limit"


def test_motion_from_a_state_that_allows_none_is_an_error():
    with pytest.raises(ValueError, match="standby"):
        state_machine.started(Life())
