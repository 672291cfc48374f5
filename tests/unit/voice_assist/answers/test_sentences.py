# SPDX-License-Identifier: BSD-3-Clause
"""Every code has one sentence or a reason for none; none is, or sounds like, a command."""

from dataclasses import replace
from functools import partial

import pytest

from rst_control.commands.table import COMMANDS
from rst_control.types import Reason
from tests.unit.voice_assist.support.records import altered
from typed_config import load_config, load_yaml
from voice_assist.alarms.presenter import event_alarm, latch_alarm, unheard_alarm
from voice_assist.alarms.types import ControllerEvent, UtteranceReport
from voice_assist.answers.sentences import TAKEN, WHY, asked, catalogue, taken, why
from voice_assist.answers.word_check import WordCheck
from voice_assist.config import CONFIG_DIR, CommandsConfig, load_voice_config
from voice_assist.text.phonetic_distance import can_pronounce
from voice_assist.types import RejectionReason

CODES = {reason.value for reason in Reason} | {reason.value for reason in RejectionReason}
COMMANDS_YAML = load_voice_config().commands
UNSPOKEN = frozenset(  # codes after which nothing is said
    {
        # Somebody stopped the robot: a further "stop" must not be hidden. The tone says it.
        *("stop_topic", "stop_command", "stop_cancel", "shutdown"),
        # Perhaps a person is saying "stop" again.
        "halt_unsure",
        # A motion ended as asked.
        *("terminated", "replaced"),
        # Other people's talk.
        "no_command",
        # The robot answered itself: to say so would be heard, too.
        "robot_speaking",
        # The command is asked for: `asked` gives the sentence.
        "nearly_sure",
    }
)
needs_sounds = pytest.mark.skipif(not can_pronounce(), reason="espeak-ng is not installed")


def test_every_code_has_one_sentence_or_is_unspoken_and_there_are_no_others():
    assert sorted([*WHY, *UNSPOKEN]) == sorted(CODES)


def test_every_command_of_the_robot_but_stop_has_a_sentence():
    camera_steps = {name for name in COMMANDS if name.split()[0] in ("look", "zoom", "camera")}
    assert set(COMMANDS) - {"stop"} - camera_steps <= set(TAKEN)


@needs_sounds
@pytest.mark.parametrize("name", ["commands.yaml", "theatre_commands.yaml"])
def test_no_sentence_holds_or_sounds_like_a_command(name):
    commands = load_config(CommandsConfig, load_yaml(CONFIG_DIR / name), name)
    check = WordCheck(commands)
    assert {s: check.objection(s) for s in catalogue() if check.objection(s)} == {}


@needs_sounds
@pytest.mark.parametrize(
    ("sentence", "found"),
    [
        ("the robot halts", "'robot' is or begins with 'robot'"),
        ("stopped by hand", "'stopped' is or begins with 'stop'"),
        ("say yes", "'yes'"),
        ("No", "'no'"),
        ("bull less", "'less'"),
        ("immense sense of it", "'tense' in sound"),
        ("a stob at it", "'stop' in sound"),
        ("poor moor", "'pull more' in sound"),
    ],
)
def test_a_word_of_a_command_and_what_sounds_like_one_is_found(sentence, found):
    assert found in WordCheck(COMMANDS_YAML).objection(sentence)


def test_words_that_only_begin_alike_are_free():
    objection = WordCheck(COMMANDS_YAML).objection
    assert objection("nothing") == ""  # "no" is a word of "no stop"


def test_what_is_refused_is_answered_by_its_code():
    refused = event_alarm(ControllerEvent("refused", "tense", "busy", "busy"), False)
    assert refused.answer == why("busy") == "still busy"
    gone = event_alarm(ControllerEvent("at_rest", "tense", "x", "closed_on_nothing"), True)
    assert gone.answer == "jaws are empty"
    unsure = UtteranceReport("", "confidence 0.31", "unsure", "tense", 0.0)
    assert unheard_alarm(unsure).answer == "unsure, say again"


def test_what_is_taken_is_answered_by_its_command():
    said = {"pull more": "drawing further", "tense 1.5 N": "taking hold", "look left": "accepted"}
    for command, sentence in said.items():
        assert event_alarm(ControllerEvent("accepted", command, ""), False).answer == sentence
        assert taken(command) == sentence


def question(phrase, commands):
    report = UtteranceReport("", "nearly sure", "nearly_sure", phrase, 0.0)
    return unheard_alarm(report, partial(asked, commands=commands)).answer


def test_a_question_names_the_motion_that_the_phrase_calls_whatever_its_words():
    amounts = load_voice_config(commands__amounts=True).commands
    assert question("pull two millimetres more", amounts) == "drawing further"
    assert question("tension one point five", amounts) == "taking hold"
    said = {"pull_more": "draw up", "release": "open", "pull_less": "release now"}
    changes = {name: {"phrase": phrase, "spellings": ()} for name, phrase in said.items()}
    other = altered(COMMANDS_YAML, **changes)
    assert question("draw up", other) == "drawing further"
    assert question("release now", other) == "easing"


def test_to_say_it_again_is_asked_for_only_where_that_is_an_answer():
    commands = altered(COMMANDS_YAML, tense={"command": "look left"})
    assert question("tense", commands) == question("of another node", commands) == ""
    assert question("tense", replace(commands, said_twice=True)) == "unsure, say again"
    german = load_voice_config(language="de").commands
    assert question("mehr ziehen", german) == "unsure, say again"


def test_after_a_stop_nothing_is_said_and_a_fault_says_why():
    assert latch_alarm("stop topic", "stop_topic", is_loaded=True).answer == ""
    assert latch_alarm("tension 2.50 N", "over_tension", is_loaded=True).answer == "too much force"
    unsure = UtteranceReport("", "confidence 0.4", "halt_unsure", "stop", 0.0)
    assert unheard_alarm(unsure).answer == ""
