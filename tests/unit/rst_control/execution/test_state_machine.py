# SPDX-License-Identifier: BSD-3-Clause
from itertools import product

import pytest

from rst_control.commands.preconditions import mode_refusal
from rst_control.commands.table import COMMANDS
from rst_control.execution import state_machine
from rst_control.types import IN_MOTION, LATCHED, Cause, ControllerMode, Reason, State

HALT = Cause(Reason.STOP_TOPIC, "stop")
FAULT = Cause(Reason.OVER_TENSION, "tension over its limit")
MOTIONS = (COMMANDS["tense"], COMMANDS["release"], COMMANDS["pull more"], COMMANDS["pull less"])


def refusal_of(mode, command):
    return mode_refusal(command, mode)


def commanded(mode, command):
    """What the executor makes of a command where the robot is healthy and all is verified."""
    if refusal_of(mode, command) is not None:
        return mode
    if command is COMMANDS["hey robot"]:
        return state_machine.activated(mode)
    if command is COMMANDS["stop"]:
        return state_machine.stopped(mode, HALT)
    if command is COMMANDS["terminate"]:
        return state_machine.terminated(mode)
    if command is COMMANDS["grasp here"]:
        return mode
    return state_machine.started(mode)


EVENTS = {
    **{c.phrase: (lambda mode, c=c: commanded(mode, c)) for c in COMMANDS.values()},
    "fault": lambda mode: state_machine.faulted(mode, FAULT),
    "failure": state_machine.failed,
    "rest": state_machine.at_rest,
}


def reachable():
    """Every mode that any sequence of events leads to, with the events that led there."""
    found, edge = {ControllerMode(): ()}, [ControllerMode()]
    while edge:
        mode = edge.pop()
        for name, event in EVENTS.items():
            after = event(mode)
            if after not in found:
                found[after] = (*found[mode], name)
                edge.append(after)
    return found


MODES = reachable()


def test_every_state_can_be_reached_and_there_are_few_modes():
    assert {mode.state for mode in MODES} == set(State)
    assert len(MODES) < 100


@pytest.mark.parametrize("command", MOTIONS)
def test_no_motion_starts_but_from_active_or_by_a_pull_that_takes_over(command):
    for mode, way in MODES.items():
        if refusal_of(mode, command) is None:
            takes_over = mode.state is State.MOVING and command.phrase in ("pull more", "pull less")
            assert mode.state is State.ACTIVE or takes_over, way
            assert mode.is_active and not mode.is_latched, way


def test_only_hey_robot_clears_a_latch():
    for mode, (name, event) in product(MODES, EVENTS.items()):
        if mode.is_latched and not event(mode).is_latched:
            assert name == "hey robot" and mode.state in LATCHED


def test_only_hey_robot_activates_and_only_terminate_ends_it():
    for mode, (name, event) in product(MODES, EVENTS.items()):
        after = event(mode)
        if after.is_active != mode.is_active:
            assert name == ("hey robot" if after.is_active else "terminate")


def test_stop_is_allowed_everywhere_and_leads_to_rest_and_a_latch():
    for mode in MODES:
        assert refusal_of(mode, COMMANDS["stop"]) is None
        after = state_machine.stopped(mode, HALT)
        assert after.is_latched and after.state is not State.MOVING
        assert state_machine.at_rest(after).state in LATCHED


def test_a_fault_in_motion_latches_whatever_else_was_going_on():
    for mode in MODES:
        if mode.state in IN_MOTION:
            assert state_machine.at_rest(state_machine.faulted(mode, FAULT)).state is State.FAULTED


def test_after_terminate_only_hey_robot_and_stop_are_heard_until_hey_robot():
    for mode in MODES:
        if refusal_of(mode, COMMANDS["terminate"]) is None:
            after = state_machine.terminated(mode)
            for command in MOTIONS:
                assert refusal_of(after, command) is not None
            assert not after.is_active


def test_refusals_name_their_reason():
    def reason(mode):
        return refusal_of(mode, COMMANDS["tense"]).reason

    assert reason(ControllerMode()) is Reason.WRONG_MODE
    moving = state_machine.started(state_machine.activated(ControllerMode()))
    assert reason(moving) is Reason.BUSY
    assert reason(state_machine.terminated(moving)) is Reason.NOT_AT_REST
    assert reason(state_machine.stopped(moving, HALT)) is Reason.HALTED
    assert reason(state_machine.faulted(moving, FAULT)) is Reason.HALTED


def test_the_first_cause_of_a_halt_is_the_one_that_is_reported():
    moving = state_machine.started(state_machine.activated(ControllerMode()))
    mode = state_machine.stopped(state_machine.faulted(moving, FAULT), HALT)
    assert state_machine.at_rest(mode).cause is FAULT


def test_motion_from_a_state_that_allows_none_is_an_error():
    with pytest.raises(ValueError, match="standby"):
        state_machine.started(ControllerMode())
