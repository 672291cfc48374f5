# SPDX-License-Identifier: BSD-3-Clause
"""The same sentences to a robot at rest and to one that moves."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tests.unit.voice_assist.support.fake_pipeline import (
    FakeSpotting,
    actions,
    commands,
    decisions,
    make,
    refusals,
    run,
)
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, say
from voice_assist.audio.robot_speech import RobotSpeechChange
from voice_assist.config import load_voice_config
from voice_assist.types import Halt, Hypothesis, Mode, RejectionReason

CONFIG = load_voice_config().moving
WITH_STOP = ("he said stop now please", "do not stop", "pulling is stop he said", "never stop more")
WITHOUT = ("he said pull more now", "do not pull less", "please release pulling", "never mumble")


class AlwaysAsSure:
    """A spotter over talk with one answer."""

    def __init__(self, score):
        self.best = self.newest = lambda sound, quiet=0.0: score
        self.follow = lambda sound: None

    def restart(self):
        """Nothing."""


def sound(text, is_moving=True):
    return [replace(frame, is_moving=is_moving) for frame in frames(say(text))]


def hear(text, is_moving, mode=Mode.ACTIVE, recognizer=None, score=None, over_talk=None, **rest):
    in_sound = None if over_talk is None else AlwaysAsSure(over_talk)
    spotting = None if score is None else FakeSpotting(score)
    made = make(mode, recognizer, spotting=spotting, stop_in_sound=in_sound, **rest)
    return run(*made, sound(text, is_moving))


@pytest.mark.parametrize("text", WITH_STOP)
@pytest.mark.parametrize("mode", Mode)
def test_a_stop_in_a_sentence_stops_a_robot_that_moves(text, mode):
    events = hear(text, True, mode)
    assert "stop" in commands(events)
    assert Halt() in actions(events)


OVER = "the now what he said is 0.36 {} 0.36 the now what he said is mumble"


@pytest.mark.parametrize("is_moving", [False, True])
def test_over_the_robots_own_voice_a_stop_is_no_harder_in_motion_than_at_rest(is_moving):
    def hear_over(word):
        pipeline, clock = make(Mode.ACTIVE, stop_in_sound=AlwaysAsSure(0.9))
        pipeline.robot_spoke(RobotSpeechChange(True, 100.0))
        return commands(run(pipeline, clock, sound(OVER.format(word), is_moving)))

    assert CONFIG.over_talk_agree > 0.9
    assert hear_over("stop") == ["stop"]
    assert hear_over("tense") == []


def test_without_that_voice_the_spotter_over_talk_is_asked_in_motion():
    assert commands(hear(OVER.format("stop"), True, over_talk=0.9)) == []


@pytest.mark.parametrize("text", WITHOUT)
@pytest.mark.parametrize("is_moving", [False, True])
def test_a_sentence_without_it_does_nothing(text, is_moving):
    assert commands(hear(text, is_moving)) == []


@pytest.mark.parametrize("command", ["tense", "release", "pull more", "pull less", "terminate"])
def test_other_commands_are_heard_in_motion_as_at_rest(command):
    assert commands(hear(command, True)) == commands(hear(command, False)) == [command]


def test_a_transcript_that_is_too_unsure_stops_nothing():
    unsure = FakeRecognizer(confidence=0.3)
    assert commands(hear(WITH_STOP[0], True, recognizer=unsure)) == []
    assert commands(hear(WITH_STOP[0], True, recognizer=FakeRecognizer(confidence=0.9))) == ["stop"]


def test_a_second_stop_in_the_same_breath_stops_again():
    assert commands(hear("he said stop now please is what he said stop", True)) == ["stop"] * 2


def test_the_newest_sound_is_heard_by_itself_only_in_motion():
    long = "he said what is the pulling what is he mumble what he said"
    at_rest, moving = FakeRecognizer(), FakeRecognizer()
    hear(long, False, recognizer=at_rest)
    hear(long, True, recognizer=moving)
    assert len(moving.heard) > len(at_rest.heard)


class AskedWhen(AlwaysAsSure):
    """A spotter over talk that hears no stop; keeps the quiet in which it is asked."""

    def __init__(self):
        super().__init__(-9.0)
        self.quiet = []
        self.best = lambda sound, quiet: self.quiet.append(quiet) or -9.0


@pytest.mark.parametrize("command", ["tense", "release", "pull more", "pull less"])
def test_a_stop_beside_a_motion_is_sought_when_its_pause_begins(command):
    in_sound, early = AskedWhen(), load_voice_config().recognizer.early
    made = make(stop_in_sound=in_sound)
    assert commands(run(*made, frames(say(command)))) == [command]
    assert in_sound.quiet == pytest.approx([early.settle, early.pause])


SPOTTER = {"moving__refuse_spotter": 1.0, "moving__spotter_alone": 3.0}


@pytest.mark.parametrize("command", ["tense", "release", "pull more", "pull less"])
@pytest.mark.parametrize("is_moving", [False, True])
def test_a_motion_with_a_stop_in_its_sound_is_refused_or_a_stop(command, is_moving):
    assert commands(hear(command, is_moving, score=0.9, **SPOTTER)) == [command]
    refused = hear(command, is_moving, score=1.5, **SPOTTER)
    assert commands(refused) == []
    assert refusals(refused)[0].rejection.reason is RejectionReason.SECOND_VOICE
    assert "stop" in commands(hear(command, is_moving, score=3.5, **SPOTTER))


@pytest.mark.parametrize(
    ("command", "rest"),
    [("hey robot", {}), ("terminate", {}), ("pull more", {"moving__is_enabled": False})],
)
def test_what_moves_nothing_is_not_refused_for_it_nor_a_motion_where_that_is_off(command, rest):
    assert commands(hear(command, False, score=1.5, **SPOTTER, **rest)) == [command]


def test_a_sure_stop_that_stands_alone_waits_for_no_word_of_the_spotter_over_talk():
    def ask(sound):
        raise AssertionError("the network was asked")

    in_sound = AlwaysAsSure(0.0)
    in_sound.newest = ask
    made = make(Mode.ACTIVE, FakeRecognizer(confidence=0.99), stop_in_sound=in_sound)
    assert commands(run(*made, sound("stop"))) == ["stop"]


@pytest.mark.parametrize("text", WITH_STOP)
def test_in_motion_a_written_stop_counts_only_if_the_spotter_over_talk_heard_it(text):
    assert commands(hear(text, True, over_talk=0.0)) == []
    assert "stop" in commands(hear(text, True, over_talk=2.0))


@pytest.mark.parametrize("text", WITHOUT)
def test_at_rest_a_stop_under_talk_counts_at_the_end_of_the_utterance(text):
    assert commands(hear(text, False, over_talk=9.0)) == ["stop"]
    assert commands(hear(text, False, over_talk=4.0)) == []


@pytest.mark.parametrize("text", WITH_STOP)
def test_at_rest_a_stop_that_is_written_in_a_sentence_is_none_however_surely_it_is_heard(text):
    for over_talk in (None, 9.0):
        assert commands(hear(text, False, over_talk=over_talk)) == []


def nearly_said(text, is_moving, score, over_talk=CONFIG.over_talk_agree, **rest):
    """A sound for which the recogniser writes a text, with its score of "stop" there [nat]."""
    recognizer = FakeRecognizer({"stop": score})
    return hear(text, is_moving, recognizer=recognizer, over_talk=over_talk, **rest)


@pytest.mark.parametrize("over_talk", [CONFIG.over_talk_agree, None])  # None: nobody is asked
@pytest.mark.parametrize("score", [0.0, -CONFIG.nearly_said])
def test_a_word_that_is_nearly_a_stop_stops_a_robot_that_moves(score, over_talk):
    events = nearly_said("mumble", True, score, over_talk)
    assert commands(events) == ["stop"]
    assert decisions(events)[0].decided_by == "recognizer"
    assert Halt() in actions(events)


@pytest.mark.parametrize(
    ("text", "is_moving", "score", "rest"),
    [
        ("mumble", False, 9.0, {}),  # at rest
        ("mumble", True, -CONFIG.nearly_said - 0.1, {}),
        ("mumble", True, 9.0, {"over_talk": CONFIG.over_talk_agree - 0.1}),
        ("he said mumble", True, 9.0, {}),  # in a sentence
        ("not", True, 9.0, {}),
        ("mumble", True, 9.0, {"moving__nearly_said": -1000.0}),
        ("mumble", True, 9.0, {"recognizer__second_opinion": False}),
    ],
)
def test_otherwise_a_word_that_is_nearly_a_stop_does_nothing(text, is_moving, score, rest):
    assert commands(nearly_said(text, is_moving, score, **rest)) == []


@pytest.mark.parametrize("command", ["tense", "release", "terminate", "pull more"])
def test_a_command_in_motion_is_no_stop_that_was_nearly_said_but_a_correction_may_be(command):
    assert commands(nearly_said(command, True, -CONFIG.nearly_said + 0.5)) != ["stop"]
    said = "pull more 0.25 mumble"  # one spotter over talk would be as sure of both
    assert commands(nearly_said(said, True, 0.0, over_talk=None)) == ["pull more", "stop"]


def test_other_languages_have_no_score_by_which_a_stop_is_nearly_said():
    """Their scores are no likelihoods: most words are within 4 spreads."""
    config = load_voice_config(language="de")
    halt = next(c.phrase for c in config.commands.commands if c.is_halt)
    recognizer = FakeRecognizer({halt: -3.0})
    assert commands(hear("mumble", True, recognizer=recognizer, config=config)) == []


def test_one_transcript_has_one_vote():
    """The pass in the pause is asked about twice: when it is made, and when the pause is over."""
    calls, config = [], load_voice_config(moving__sentence_agreement=2, moving__nearly_said=-1000.0)
    made = make(Mode.ACTIVE, FakeRecognizer(), config=config)
    decider = made[0]._decider.stops
    before = decider.in_motion

    def in_motion(transcript, partial):
        found = before(transcript, partial)
        calls.append((transcript, decider._votes))
        return found

    decider.in_motion = in_motion
    run(*made, sound("he said mumble stop"))
    votes = {}
    for transcript, count in calls:
        votes.setdefault(id(transcript), set()).add(count)
    assert calls and all(len(counts) == 1 for counts in votes.values())


@pytest.mark.parametrize("over_talk", [True, False])
def test_a_stop_that_the_last_transcript_alone_holds_needs_no_second_one(over_talk):
    """After the pause there is no other transcript, so the last word is written only once."""
    config = load_voice_config(moving__sentence_agreement=2, spotter__over_talk=False)
    stops = make(Mode.ACTIVE, FakeRecognizer(), config=config)[0]._decider.stops
    if over_talk:
        stops._stop_in_sound, stops.halts = object(), ("halt",)
    halt = stops.halts[0]

    def sure(words, quiet):
        return stops.in_motion(Hypothesis(words, 0.9, 0.0), SimpleNamespace(quiet=quiet))

    pause = config.recognizer.early.pause
    assert sure(f"that will do {halt}", quiet=0.0) is None
    assert sure("that will do", quiet=pause) is None
    assert sure(f"that will do {halt}", quiet=pause).outcome.command == halt


@pytest.mark.parametrize("is_moving", [False, True])
def test_a_halt_that_the_spotter_over_talk_does_not_know_needs_no_word_from_it(is_moving):
    config = load_voice_config()
    (stop,) = (c for c in config.commands.commands if c.is_halt)
    both = (*config.commands.commands, replace(stop, phrase="please", spellings=()))
    config = replace(config, commands=replace(config.commands, commands=both))
    heard = commands(hear("he said please now", is_moving, over_talk=0.0, config=config))
    assert heard == (["please"] if is_moving else [])
