# SPDX-License-Identifier: BSD-3-Clause
"""Bad words at the queue: nothing but a refusal, and no motion but by the command itself."""

import tracemalloc

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rst_control.admission.command_queue import CommandQueue
from rst_control.commands.parser import MAX_LENGTH, is_stop, read_command, shown, unknown
from rst_control.commands.table import COMMANDS
from rst_control.types import Cause, Reason, State
from tests.support.bad_words import BROKEN, HUGE, MOTIONS, NO_STOPS, STOPS, disguises, huge
from tests.support.null_executor import Nobody
from tests.unit.rst_control.support.executor_rig import Rig

SAID = st.text(max_size=30) | st.text("tensopurl mhyb.\u200d\u0455\uff53\u0301\x00", max_size=12)

FORBIDDEN = Cause(Reason.MAY_NOT_COMMAND, "may not call")


def named(texts):
    return [pytest.param(text, id=f"{number}-{shown(text, 12)!a}") for number, text in texts]


@pytest.mark.parametrize("command", MOTIONS)
def test_what_only_looks_like_a_command_is_none(command):
    for text in disguises(command):
        assert read_command(text) is None, ascii(text[:60])


@pytest.mark.parametrize("text", named(enumerate(BROKEN)))
def test_broken_texts_are_refused_in_one_printable_line(text):
    assert read_command(text) is None
    assert unknown(text).words.isprintable() and len(unknown(text).words) < 400


@pytest.mark.parametrize(("beginning", "repeated"), HUGE, ids=range(len(HUGE)))
def test_ten_million_characters_take_no_memory_and_move_nothing(beginning, repeated):
    text = huge(beginning, repeated)
    tracemalloc.start()
    command, words = read_command(text), unknown(text).words
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert command in (None, COMMANDS["stop"])
    assert peak < 100_000
    assert str(len(text)) in words and str(MAX_LENGTH) in words and len(words) < 400


@pytest.mark.parametrize("text", named(enumerate(STOPS)))
def test_a_stop_in_whatever_harmless_dress_stops_at_once(text):
    nobody = Nobody()
    queue = CommandQueue(nobody, lambda *_: None, lambda: 0.0)
    assert is_stop(text)
    assert queue.take(text, "test").reply.result(0).accepted
    assert len(nobody.stops) == 1 and nobody.orders == []


@pytest.mark.parametrize("text", named(enumerate(NO_STOPS)))
def test_what_is_no_stop_is_no_stop(text):
    assert not is_stop(text)
    assert read_command(text) is None


def test_a_stop_is_taken_from_a_caller_of_whom_nothing_else_is():
    rig = Rig().awake()
    pending = rig.queue.take("terminate", "stray", refusal=FORBIDDEN)
    assert pending.reply.result(0).message == "may not call"
    assert pending.ended.result(0).kind == "refused"
    assert rig.queue.take("Stop.", "stray", refusal=FORBIDDEN).reply.result(0).accepted
    rig.tick()
    assert rig.state is State.HALTED


@given(SAID)
def test_a_text_is_a_command_only_if_it_is_one_letter_by_letter(text):
    command = read_command(text)
    if command is not None and command is not COMMANDS["stop"]:
        assert " ".join(text.split()).lower() == command.phrase
        assert text.isascii()


@given(st.text(max_size=60))
def test_a_refusal_names_what_no_command_has(text):
    words = unknown(text).words
    assert words.isprintable() and len(words) < 400
    if not text.isascii():
        assert f"U+{ord(next(c for c in text if not c.isascii())):04X}" in words


def test_the_length_of_what_was_not_read_is_named():
    assert "10000000 bytes, allowed: 200" in unknown("x" * 400, 10_000_000).words


@settings(max_examples=20)
@given(st.lists(SAID, max_size=20))
def test_no_flood_of_texts_moves_a_robot_that_is_awake(texts):
    rig = RIG
    texts = [text for text in texts if read_command(text) is None]
    before = len(rig.sent)
    for text in texts:
        assert not rig.queue.take(text, "test").reply.result(0).accepted
        rig.tick()
    held = [s.position.tolist() for s in rig.sent[before:] if s is not None]
    assert all(position == held[0] for position in held)
    assert rig.state is State.ACTIVE


RIG = Rig().awake()


def test_the_commands_themselves_are_taken():
    for words, command in COMMANDS.items():
        assert read_command(words) is command
        assert read_command(f"\t {words.upper()}\r\n") is command
