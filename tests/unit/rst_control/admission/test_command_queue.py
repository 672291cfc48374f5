# SPDX-License-Identifier: BSD-3-Clause
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rst_control.admission import command_queue
from rst_control.admission.command_queue import CommandQueue
from rst_control.commands.parser import MAX_ECHOED, read_command, unknown
from rst_control.commands.table import COMMANDS
from rst_control.types import Cause, Reason, State
from tests.unit.rst_control.support.executor_rig import Rig


@pytest.mark.parametrize("command", COMMANDS.values(), ids=tuple(COMMANDS))
def test_every_command_is_read_whatever_its_case_and_spaces(command):
    assert read_command(f"  {command.phrase.upper()} ") is command
    assert read_command(command.phrase.replace(" ", "  ")) is command


@pytest.mark.parametrize(
    "words", ["", " ", "pull", "tense now", "te nse", "heyrobot", "ｓｔｏｐ", "tense!", "tense\x00"]
)
def test_what_only_resembles_a_command_is_none(words):
    assert read_command(words) is None


@given(st.text(max_size=2000))
def test_any_text_is_answered_in_a_few_printable_characters(words):
    refusal = unknown(words).words
    assert len(refusal) < 400
    assert refusal.isprintable()
    for command in COMMANDS.values():
        assert command.phrase in refusal


def test_unknown_words_are_refused_at_once_and_written_into_the_diary():
    rig = Rig().awake()
    pending = rig.queue.take("x" * 10_000_000, "test")
    assert not pending.reply.result(0).accepted
    entry = rig.executor.events[-1]
    assert entry.kind == "refused" and len(entry.command) == MAX_ECHOED


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


@pytest.mark.parametrize("amount", [float("nan"), float("inf"), -1.0])
def test_amounts_that_make_no_sense_are_refused(amount):
    rig = Rig().awake()
    assert "numbers from 0" in rig.refused("tense", tension=amount)
    assert "numbers from 0" in rig.refused("pull more", distance=amount)


def test_commands_beyond_the_queue_are_refused_and_stop_is_never_queued():
    rig = Rig().awake()
    pending = [rig.queue.take("tense", "test") for _ in range(command_queue.WAITING + 5)]
    assert sum(t.reply.done() for t in pending) == 5
    assert rig.queue.take("stop", "test").reply.result(0).accepted
    rig.tick()
    assert rig.state is State.HALTED


def test_a_command_verified_in_a_situation_that_has_changed_is_verified_again():
    rig = Rig().awake()
    pending = rig.queue.take("tense", "test")
    rig.queue.check(rig.queue.next(0.0))
    rig.executor.stop(Cause(Reason.STOP_TOPIC, "in between"))
    rig.tick()
    assert not pending.reply.result(0).accepted
    rig.say("hey robot")

    pending = rig.queue.take("tense", "test")
    rig.queue.check(rig.queue.next(0.0))
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
