# SPDX-License-Identifier: BSD-3-Clause
"""What waits to be verified when the robot is stopped does not begin after the next "hey robot"."""

import pytest

from rst_control.types import Reason, State
from tests.unit.rst_control.support.executor_rig import Rig

ENDS = {
    "a stop": Rig.stop,
    "terminate": lambda rig: rig.say("terminate"),
    "a fault": lambda rig: rig.executor.crashed(RuntimeError("test")),
}


@pytest.mark.parametrize("end", ENDS.values(), ids=ENDS)
def test_what_was_given_before_never_begins(end):
    rig = Rig().awake()
    pending = rig.queue.take("tense", "test")
    waiting = rig.queue.next(0.0)
    end(rig)
    rig.run(0.1)
    rig.say("hey robot")
    assert rig.state is State.ACTIVE
    rig.queue.check(waiting)
    rig.run(0.1)
    assert not pending.reply.result(0).accepted
    assert pending.reply.result(0).reason is Reason.HALTED
    assert rig.state is State.ACTIVE and rig.still_for(0.2)


def test_nor_does_what_was_verified_and_waits_for_its_tick():
    rig = Rig().awake()
    pending = rig.verified()
    rig.stop()
    rig.queue.take("hey robot", "test")
    rig.run(0.1)
    rig.say("hey robot")
    while (waiting := rig.queue.next(0.0)) is not None:
        rig.queue.check(waiting)
    rig.run(0.1)
    assert not pending.reply.result(0).accepted
    assert rig.still_for(0.2)


@pytest.mark.parametrize("is_stop_first", [True, False])
def test_a_stop_and_a_command_in_the_same_tick_hold_in_either_order(is_stop_first):
    rig = Rig().awake()
    if is_stop_first:
        rig.stop()
    pending = rig.verified()
    if not is_stop_first:
        rig.stop()
    rig.run(0.1)
    assert rig.state is State.HALTED and rig.still_for(0.2)
    while (waiting := rig.queue.next(0.0)) is not None:
        rig.queue.check(waiting)
        rig.run(0.01)
    assert not pending.reply.result(0).accepted


def test_an_error_at_each_tick_is_logged_once_and_again_when_it_comes_back(caplog):
    rig, error = Rig(), RuntimeError("test")
    for _ in range(3):
        rig.executor.crashed(error)
    assert len(caplog.records) == 1
    rig.tick()
    rig.executor.crashed(error)
    assert [record.getMessage() for record in caplog.records] == [
        "error in the control loop: RuntimeError('test')"
    ] * 2
