# SPDX-License-Identifier: BSD-3-Clause
from hypothesis import given
from hypothesis import strategies as st

from voice_assist.config import load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.text.normalize import NEGATIONS
from voice_assist.types import Match

CONFIG = load_voice_config().commands
MAPPER = Mapper(CONFIG)
MOTIONS = [command.phrase for command in CONFIG.commands if command.is_motion]
WORDS = (
    "hey robot tense release pull more less stop terminate the please now it a not no don't never"
)
SENTENCES = st.lists(st.sampled_from(WORDS.split()), max_size=7)
WITHIN = st.tuples(SENTENCES, st.sampled_from([*MOTIONS, *sorted(NEGATIONS)]), SENTENCES)
MARKS = st.sampled_from(["", ".", "!", ", ", "?", " "])


def taken(text):
    outcome = MAPPER(text)
    return outcome.command if isinstance(outcome, Match) else ""


@given(SENTENCES | WITHIN.map(lambda parts: [*parts[0], parts[1], *parts[2]]))
def test_only_a_spelling_itself_is_ever_taken_for_a_motion(words):
    """Not inside a longer sentence, and never with a denial."""
    command = taken(" ".join(words))
    if command in MOTIONS:
        assert " ".join(words) == command


@given(SENTENCES, MARKS, st.sampled_from([str.upper, str.title, str.lower]))
def test_capitals_and_marks_make_no_difference(words, mark, change):
    plain = " ".join(words)
    assert taken(change(plain) + mark) == taken(plain)


@given(SENTENCES)
def test_every_command_gets_an_error_and_the_match_has_the_lowest(words):
    outcome = MAPPER(" ".join(words))
    assert tuple(outcome.wer) == CONFIG.phrases
    assert all(error >= 0.0 for error in outcome.wer.values())
    if isinstance(outcome, Match):
        others = [error for phrase, error in outcome.wer.items() if phrase != outcome.command]
        assert outcome.wer[outcome.command] < CONFIG.get(outcome.command).threshold
        assert outcome.wer[outcome.command] <= min(others) or outcome.command == "stop"


@given(SENTENCES, SENTENCES, st.integers(0, 5))
def test_what_cannot_become_a_command_never_does(beginning, rest, letters):
    said = " ".join(beginning) + " "
    if MAPPER.cannot_become(said + "stop"[:letters]):
        assert not taken(said + "stop"[:letters] + " ".join(rest))


@given(SENTENCES.filter(bool), st.integers(1, 30))
def test_beginnings_of_what_is_taken_can_become_it(words, length):
    text = " ".join(words)
    if taken(text):
        assert not MAPPER.cannot_become(text[:length])
