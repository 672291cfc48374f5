# SPDX-License-Identifier: BSD-3-Clause
"""Bad words as a transcript: whatever a recogniser may write, nothing moves by it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.bad_words import BROKEN, HUGE, disguises, huge
from voice_assist.config import load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.text.normalize import LONGEST, foreign, is_too_long, normalize
from voice_assist.types import Match

CONFIG = load_voice_config().commands
MAPPER = Mapper(CONFIG)
HALTS = {command.phrase for command in CONFIG.commands if command.is_halt}
OTHERS = [command.phrase for command in CONFIG.commands if not command.is_halt]
SAID = st.text(max_size=40) | st.text("tensopurl mhyb'.\u200d\u0455\uff53\u0301\x00", max_size=15)
# What a recogniser may well write around a command; these are the command.
HARMLESS = (
    *("{}", " {}. ", "{}!", "\u201c{}\u201d", "{}\u2026"),
    *("\u00a0{}\u3002", "{}\x00", "{}\x1f"),
)


def taken(text):
    outcome = MAPPER(text)
    return outcome.command if isinstance(outcome, Match) else ""


@pytest.mark.parametrize("command", OTHERS)
def test_what_only_looks_like_a_command_is_none(command):
    harmless = {command + "\x00", "\x00" + command, command + "\x1f"}
    harmless |= {command.replace(" ", "\u00a0"), command + "\u3000"}
    for text in disguises(command):
        if text not in harmless:
            assert taken(text) in {"", *HALTS}, ascii(text[:60])


@pytest.mark.parametrize("command", OTHERS)
@pytest.mark.parametrize("dress", HARMLESS)
def test_marks_around_a_command_do_not_matter(command, dress):
    assert taken(dress.format(command)) == command


@pytest.mark.parametrize("dress", [*HARMLESS, "\uff33\uff34\uff2f\uff30", "st\u00f6p", "{}\u200d"])
def test_a_halt_is_taken_more_kindly(dress):
    assert taken(dress.format("stop")) == "stop"


@pytest.mark.parametrize(("beginning", "repeated"), HUGE, ids=range(len(HUGE)))
def test_ten_million_characters_are_refused_by_their_number(beginning, repeated):
    text = huge(beginning, repeated)
    outcome = MAPPER(text)
    assert not isinstance(outcome, Match)
    assert outcome.rejection.words == f"{len(text)} characters, allowed: {LONGEST}"
    assert tuple(outcome.wer) == CONFIG.phrases
    assert len(normalize(text)) <= 18 * LONGEST
    MAPPER.can_grow(text)


@pytest.mark.parametrize("text", [pytest.param(t, id=str(n)) for n, t in enumerate(BROKEN)])
def test_broken_texts_move_nothing(text):
    assert taken(text) == "" or text.split() == ["tense"]


def test_a_command_far_ahead_of_its_denial_is_none():
    for gap in (LONGEST - 10, LONGEST, LONGEST + 10):
        assert taken("tense" + " " * gap + "not") == ""


def test_the_longest_text_is_still_read():
    text = "tense" + " " * (LONGEST - 5)
    assert not is_too_long(text) and taken(text) == "tense"
    assert is_too_long(text + " ") and taken(text + " ") == ""


@pytest.mark.parametrize(
    ("text", "odd"),
    [("", ""), ("a\u2019b \u2014 c\u2026", ""), ("\u0455top", "\u0455"), ("x\u0301", "\u0301")],
)
def test_letters_that_english_has_not_are_found(text, odd):
    assert foreign(text) == odd


@given(SAID)
def test_no_text_moves_but_the_words_of_a_command(text):
    command = taken(text)
    if command and command not in HALTS:
        spellings = MAPPER.accepted()[command]
        assert " ".join(normalize(text)) in spellings
        assert foreign(text) == ""
