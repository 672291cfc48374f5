# SPDX-License-Identifier: BSD-3-Clause
"""What is said during a motion neither clears the latch it brakes into nor renames it."""

import numpy as np
import pytest

from rst_control.types import Reason, State
from tests.unit.rst_control.support.executor_rig import Rig


def commands(rig, *kinds):
    return [event.command for event in rig.executor.events if event.kind in kinds]


def test_hey_robot_in_the_tick_of_a_fault_is_refused_and_clears_nothing():
    rig = Rig().moving("reach")
    rig.executor.events.clear()
    pending = rig.queue.take("hey robot", "test")
    rig.robot.fault = "broken"
    rig.robot.hold()
    rig.until(pending.reply.done)
    reply = pending.reply.result(0)
    assert not reply.accepted and reply.reason is Reason.WITHDRAWN
    assert reply.message == "it came before a fault"
    assert rig.state is State.STOPPING and rig.view.mode.mode_after is State.FAULTED
    rig.rest()
    assert rig.state is State.FAULTED
    assert commands(rig, "accepted", "cleared") == []
    assert commands(rig, "refused") == ["hey robot"]
    rig.say("hey robot")
    assert rig.state is State.ACTIVE and commands(rig, "cleared") == ["hey robot"]


def test_hey_robot_in_motion_leaves_the_motion_its_name():
    rig = Rig().moving("reach")
    rig.say("hey robot")
    assert rig.view.command == "tense"
    rig.rest(30.0)
    assert commands(rig, "motion_started", "motion_finished") == ["tense", "tense"]
    rig.say("hey robot")
    assert rig.view.command == "hey robot"  # nothing is in motion: it is the last one


@pytest.mark.parametrize("words", ["terminate", "stop"])
def test_what_ends_a_motion_leaves_it_its_name(words):
    rig = Rig().moving("reach")
    rig.say("hey robot")
    rig.say(words)
    assert rig.view.command == "tense"
    rig.rest()
    assert set(commands(rig, "at_rest", "halted")) == {"tense"}


def test_a_motion_that_takes_over_has_its_own_name():
    rig = Rig().moving("pull")
    rig.say("hey robot")
    rig.finish("pull more")
    assert commands(rig, "motion_finished") == ["pull more"]
    assert rig.view.command == "pull more"


def test_hey_robot_in_the_tick_of_a_sensor_fault_does_not_clear_it_later():
    rig, off = Rig().moving("reach"), np.zeros(10)
    off[0] = 0.01
    pending = rig.queue.take("hey robot", "test")
    rig.robot.push(off)
    rig.tick()
    rig.robot.push(-off)
    rig.run(0.6)  # longer than the objection, and than the time of a reset
    assert rig.state is State.FAULTED and rig.view.mode.cause.reason is Reason.SENSOR_FAULT
    assert not pending.reply.result(0).accepted
    assert commands(rig, "cleared") == []
    rig.say("hey robot")
    assert rig.state is State.ACTIVE
