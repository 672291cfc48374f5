# SPDX-License-Identifier: BSD-3-Clause
import pytest

from rst_control.admission import command_queue
from rst_control.admission.command_queue import CommandQueue
from rst_control.commands.parser import MAX_ECHOED
from rst_control.types import Reason, State
from tests.unit.rst_control.support.executor_rig import Rig


def test_unknown_words_are_refused_at_once_and_written_into_the_event_log():
    rig = Rig().awake()
    pending = rig.queue.take("x" * 10_000_000, "test")
    assert not pending.reply.result(0).accepted
    event = rig.executor.events[-1]
    assert event.kind == "refused" and len(event.command) == MAX_ECHOED


def test_what_is_accepted_or_refused_names_its_caller():
    rig = Rig().awake()
    rig.queue.take("nonsense", "/pedal")
    pending = rig.queue.take("release", "/voice_assist")
    rig.queue.check(rig.queue.next(0.0))
    rig.queue.take("terminate", "/display")
    rig.tick()
    assert not pending.reply.result(0).accepted
    named = [(e.kind, e.command, e.caller) for e in rig.executor.events if e.caller != "test"]
    assert named[-3:] == [
        ("refused", "nonsense", "/pedal"),
        ("refused", "release", "/voice_assist"),
        ("accepted", "terminate", "/display"),
    ]


def test_commands_beyond_the_queue_are_refused_and_stop_is_never_queued():
    rig = Rig().awake()
    pending = [rig.queue.take("tense", "test") for _ in range(command_queue.WAITING + 5)]
    assert sum(t.reply.done() for t in pending) == 5
    assert rig.queue.take("stop", "test").reply.result(0).accepted
    rig.tick()
    assert rig.state is State.HALTED


def test_a_command_verified_in_a_situation_that_has_changed_is_verified_again():
    rig = Rig().awake()
    pending = rig.verified()
    rig.stop()
    rig.tick()
    assert not pending.reply.result(0).accepted
    rig.say("hey robot")

    pending = rig.verified()
    rig.executor._setpoint_state.changes += 1
    rig.tick()
    assert not pending.reply.done()
    rig.queue.check(rig.queue.next(0.0))
    rig.tick()
    assert pending.reply.result(0).accepted


def test_a_verification_that_raises_refuses_the_command_with_the_error():
    rig = Rig().awake()

    def verify(request, situation):
        raise ArithmeticError("singular")

    broken = CommandQueue(rig.executor, verify, lambda: rig.now)
    pending = broken.take("tense", "test")
    queued = broken.next(0.0)
    with pytest.raises(ArithmeticError):
        broken.check(queued)
    broken.fail(queued, ArithmeticError("singular"))
    assert "singular" in pending.reply.result(0).message
    assert pending.ended.result(0).kind == "refused"


def test_a_command_that_is_given_up_while_it_waits_is_not_planned():
    rig = Rig().awake()
    pending = rig.queue.take("tense", "/voice_assist")
    assert pending.reply.cancel()
    rig.queue.check(rig.queue.next(0.0))
    rig.run(0.01)
    assert rig.state is State.ACTIVE
    assert pending.ended.result(0).reason is Reason.WITHDRAWN
    entry = rig.executor.events[-1]
    assert (entry.kind, entry.command, entry.reason) == ("refused", "tense", Reason.WITHDRAWN)


@pytest.mark.parametrize("words", ["tense", "hey robot"])
def test_a_command_that_is_given_up_before_the_control_loop_takes_it_is_not_carried_out(words):
    rig = Rig().awake()
    if words == "hey robot":
        rig.stop()
        rig.tick()
    before = rig.state
    pending = rig.verified() if words == "tense" else rig.queue.take(words, "test")
    assert pending.reply.cancel()
    rig.run(0.01)
    assert rig.state is before
    assert pending.ended.result(0).reason is Reason.WITHDRAWN
    assert rig.say("hey robot")  # what is given now counts


def test_a_command_that_was_taken_up_cannot_be_given_up_any_more():
    rig = Rig().awake()
    pending = rig.say("tense")
    assert not pending.reply.cancel()
    assert rig.state is State.MOVING


def test_the_time_of_the_last_command_is_known_whoever_gave_it_and_whatever_came_of_it():
    rig = Rig().awake()
    for words in ("tense", "stop", "nonsense"):
        rig.run(1.0)
        before = rig.now
        rig.give(words, spoken=True)
        assert before <= rig.queue.last_command <= rig.now
