# SPDX-License-Identifier: BSD-3-Clause
import pytest

from tests.unit.voice_assist.support.records import command_entries
from voice_assist.config import load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.types import Match, NoMatch, Rejection, RejectionReason

COMMANDS = load_voice_config().commands
MAPPER = Mapper(COMMANDS)

TAKEN = {
    "hey robot": ["hey robot", "Hey, robot.", "HEY ROBOT!", " hey  robot ", "Heyrobot."],
    "tense": ["tense", "Tense.", "TENSE!"],
    "release": ["release", "Release!"],
    "pull more": ["pull more", "Pull more.", "pull-more", "PULL, MORE", "Pullmore!"],
    "pull less": ["pull less", "Pull less!"],
    "stop": [
        "stop",
        "Stop!",
        "stop, stop",
        "Stop! Stop! Stop!",
        "stop now",
        "please stop",
        "no, stop!",
        "stopstop",
        "nostop",
    ],
    "terminate": ["terminate", "Terminate."],
}
TALK = """
... | thank you | pull | more | less | hey | robot | tents | dense | tens | tension | intense |
pretense | tensed | tense up | tense tense | least | lease | police | re lease | released |
releasing | the release form | release forms | release it | please release | full more |
pull moor | bull more | poor more | pull more gauze | pull me more | more pull |
pull less hard | less pull | pull more or less | pull more pull less | shop | top | step |
stopped | stopping | stop pulling | stopwatch | stop the bleeding | non stop | bus stop |
don't stop | do not stop | never stop | don't pull more | do not pull less | never release |
not tense | no pull more | don't terminate | terminal | terminated | termination |
terminate it | germinate | a robot | hey robin | they rob it | hey robot arm | robot |
hey robot look | hey | can you pass me the scissors | he told me to pull more shifts |
pull more is what he said | i would release it and pull more | the tension is high |
we should stop for coffee later | zero one two | 5 | hey robot tense | tense release | no |
not | never | stop not | stop no | no tense | less more | pull les | pul more | hey robots |
pullmore gauze | pullmorepullless | pull moreor | tensetense | nopullmore | not pullmore |
heyrobots | hey heyrobot | pullmores | pul lmore | stopit | nonstop | unstop | stoprelease | st op
"""
IGNORED = ["", "   ", *(text.strip() for text in TALK.split("|"))]


@pytest.mark.parametrize(
    ("command", "text"), [(command, text) for command, texts in TAKEN.items() for text in texts]
)
def test_a_command_is_taken_in_each_of_its_spellings(command, text):
    outcome = MAPPER(text)
    assert isinstance(outcome, Match)
    assert outcome.command == command
    assert outcome.wer[command] == 0.0


@pytest.mark.parametrize("text", IGNORED)
def test_what_is_no_command_does_nothing(text):
    outcome = MAPPER(text)
    assert isinstance(outcome, NoMatch)
    assert outcome.rejection.words


def test_a_tie_is_no_match_and_names_both():
    entries = command_entries()
    for entry in entries:
        if entry["phrase"] in ("pull more", "pull less"):
            longer = {"pull more": "now pull more here", "pull less": "now pull less there"}
            entry.update(phrase=longer[entry["phrase"]], threshold=0.45)
    outcome = Mapper(load_voice_config(commands__commands=entries).commands)("now pull more there")
    assert isinstance(outcome, NoMatch)
    words = "it fits 'now pull more here' and 'now pull less there' equally well"
    assert outcome.rejection.words == words


def test_the_nearest_command_and_its_error_are_named():
    outcome = MAPPER("pull more gauze")
    assert outcome.nearest_command == "pull more"
    assert outcome.rejection.words == "WER 0.50 to 'pull more', allowed below 0.50"


@pytest.mark.parametrize(
    ("text", "nearest"),
    [
        ("tents", "tense"),
        ("full moor", "pull more"),
        ("germinate", "terminate"),
        ("is there more water in that bowl", "pull more"),
        ("could you hand me the scissors please", "release"),
        ("never hey robot", "hey robot"),
        ("do not stop", "stop"),
    ],
)
def test_the_nearest_command_is_by_sound(text, nearest):
    assert MAPPER(text).nearest_command == nearest


@pytest.mark.parametrize(
    ("text", "command"),
    [
        ("Dense.", "tense"),
        ("bull less", "pull less"),
        ("pull us", "pull less"),
        ("we lease", "release"),
        ("step", "stop"),
        ("a robot", "hey robot"),
    ],
)
def test_a_whole_text_may_sound_almost_like_a_command(text, command):
    assert isinstance(MAPPER(text), NoMatch)
    almost = MAPPER.almost(text, 0.25)
    assert (almost.command, almost.wer) == (command, MAPPER(text).wer)


DENIES = ("", "no bull less", "ten", "bull less ñ", "tense up", "pull more gauze", "release it")
OTHERWISE = ("thank you", "police", "the past dense of it", "pull")


@pytest.mark.parametrize(
    ("text", "near"),
    [
        *((text, 0.4) for text in (*DENIES, "stop bull less", "stop dense")),
        *((text, 0.25) for text in OTHERWISE),
    ],
)
def test_what_denies_has_more_in_it_or_sounds_otherwise_is_almost_none(text, near):
    assert MAPPER.almost(text, near) is None


def test_talk_is_not_all_near_the_command_with_the_longest_spelling():
    talk = [text for text in IGNORED if len(text.split()) > 3]
    stops = [text for text in talk if MAPPER(text).nearest_command == "stop"]
    assert len(talk) > 5 and all("stop" in text for text in stops), stops


def test_what_runs_together_is_parted_only_where_no_command_has_that_word():
    entries = command_entries()
    entries[3] |= {"phrase": "camera closer", "command": "camera closer"}
    entries[4] |= {"phrase": "in sight", "spellings": ["on pullmore"]}
    mapper = Mapper(load_voice_config(commands__commands=entries).commands)
    outcome = mapper("Cameracloser.")
    assert isinstance(outcome, Match) and outcome.wer["camera closer"] == 0.0
    assert mapper.words("insight") == ("in", "sight")
    assert mapper.words("pullmore") == ("pullmore",)
    assert not mapper.cannot_become("cameracloser ") and mapper.cannot_become("the cameracloser ")


def test_silence_has_no_nearest_command():
    nothing, outcome = Rejection(RejectionReason.NO_COMMAND, "nothing was said"), MAPPER("")
    assert outcome == NoMatch(nothing, "", outcome.wer) and set(outcome.wer) == set(TAKEN)


def test_the_lowest_error_below_its_own_threshold_wins():
    entries = command_entries()
    for entry in entries:
        entry["threshold"] = 0.5 if entry["phrase"] == "pull less" else 0.3
        if entry["phrase"] == "pull less":
            entry["phrase"] = "please pull less"
    outcome = Mapper(load_voice_config(commands__commands=entries).commands)("please pull mess")
    assert isinstance(outcome, Match) and outcome.command == "please pull less"


def test_no_shipped_command_can_grow_into_another_but_a_halt():
    assert not any(MAPPER.can_grow(text) for text in (*TAKEN, "pull over"))
    assert MAPPER.can_grow("pull") and MAPPER.can_grow("hey")


def test_all_accepted_phrases_are_listed():
    accepted = MAPPER.accepted()
    assert set(accepted) == set(TAKEN)
    assert accepted["pull more"] == ("pull more",)
    assert "stop stop" in accepted["stop"]


@pytest.mark.parametrize(
    ("beginning", "is_lost"),
    [
        ("", False),
        ("pull", False),
        ("hey robo", False),
        ("the", False),  # may be part of a word
        ("stop stop stop it", False),  # one more "stop" makes it a stop with one word wrong
        ("the ", False),  # "the stop stop stop stop" is one too
        ("the patient ", True),
        ("pull them more ", True),
        ("what he said is st", True),
    ],
)
def test_beginnings_that_no_command_has(beginning, is_lost):
    assert MAPPER.cannot_become(beginning) is is_lost
