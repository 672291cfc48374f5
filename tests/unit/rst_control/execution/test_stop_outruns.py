# SPDX-License-Identifier: BSD-3-Clause
"""A stop is not cleared by a "hey robot" that came before it, though both wait for one tick."""

from rst_control.types import Cause, Reason, State
from tests.unit.rst_control.support.executor_rig import Rig


def asked(rig, count=1):
    return [rig.queue.take("hey robot", "test") for _ in range(count)]


def test_a_hey_robot_that_came_before_a_stop_does_not_clear_it():
    rig = Rig().run(0.01)
    (pending,) = asked(rig)
    rig.executor.stop(Cause(Reason.STOP_TOPIC, "test"))
    rig.tick()
    assert rig.state is State.HALTED
    assert "stopped meanwhile" in pending.reply.result(0).message
    rig.say("hey robot")
    assert rig.state is State.ACTIVE


def test_nor_do_many_that_take_more_than_one_tick():
    rig = Rig().run(0.01)
    pending = asked(rig, count=10)
    rig.executor.stop(Cause(Reason.STOP_TOPIC, "test"))
    for _ in range(5):
        rig.tick()
        assert rig.state is State.HALTED
    assert not any(each.reply.result(0).accepted for each in pending)


def test_one_that_came_after_the_stop_was_taken_up_clears_it():
    rig = Rig().run(0.01)
    asked(rig, count=10)
    rig.executor.stop(Cause(Reason.STOP_TOPIC, "test"))
    rig.tick()
    (later,) = asked(rig)
    rig.run(0.01)
    assert later.reply.result(0).accepted and rig.state is State.ACTIVE
