# SPDX-License-Identifier: BSD-3-Clause
"""A "hey robot" clears no stop that came after it, and wakes nobody after a "terminate"."""

import pytest

from rst_control.types import State
from tests.unit.rst_control.support.executor_rig import Rig


def asked(rig, count=1):
    return [rig.queue.take("hey robot", "test") for _ in range(count)]


def test_a_hey_robot_that_came_before_a_stop_does_not_clear_it():
    rig = Rig().run(0.01)
    (pending,) = asked(rig)
    rig.stop()
    rig.tick()
    assert rig.state is State.HALTED
    assert "stopped meanwhile" in pending.reply.result(0).message
    rig.say("hey robot")
    assert rig.state is State.ACTIVE


def test_nor_do_many_that_take_more_than_one_tick():
    rig = Rig().run(0.01)
    pending = asked(rig, count=10)
    rig.stop()
    for _ in range(5):
        rig.tick()
        assert rig.state is State.HALTED
    assert not any(each.reply.result(0).accepted for each in pending)


def test_nor_does_one_that_was_held_up_until_the_stop_was_taken_up(monkeypatch):
    rig = Rig().run(0.01)
    post = rig.executor.post

    def post_late(order):
        rig.stop()
        rig.tick()
        post(order)

    monkeypatch.setattr(rig.executor, "post", post_late)
    (pending,) = asked(rig)
    rig.tick()
    assert "stopped meanwhile" in pending.reply.result(0).message
    assert rig.state is State.HALTED


def test_one_that_came_after_the_stop_was_taken_up_clears_it():
    rig = Rig().run(0.01)
    asked(rig, count=10)
    rig.stop()
    rig.tick()
    (later,) = asked(rig)
    rig.run(0.01)
    assert later.reply.result(0).accepted and rig.state is State.ACTIVE


@pytest.mark.parametrize("is_terminated", [True, False])
def test_one_that_waits_for_a_fault_to_clear_wakes_nobody_after_terminate(is_terminated):
    rig = Rig().moving("reach")
    rig.robot.fault, rig.robot.clears_fault = "brakes on", False
    rig.robot.hold()
    rig.rest()
    (waiting,) = asked(rig)
    rig.run(0.01)
    assert not waiting.reply.done()
    if is_terminated:
        rig.say("terminate")
        assert "terminated" in waiting.reply.result(0).message
    rig.robot.fault = ""
    rig.run(0.5)
    assert rig.view.mode.is_active is not is_terminated
    assert rig.state is (State.FAULTED if is_terminated else State.ACTIVE)
