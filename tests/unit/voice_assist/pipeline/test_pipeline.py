# SPDX-License-Identifier: BSD-3-Clause
"""What the pipeline decides about commands and about talk, and when."""

import numpy as np
import pytest

from tests.unit.voice_assist.support.fake_pipeline import (
    COMMANDS,
    FakeSpotting,
    commands,
    decisions,
    hear,
    make,
    refusals,
    run,
)
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, say, silence
from tests.unit.voice_assist.support.records import command_entries
from voice_assist.audio.talk_gate import TalkChange
from voice_assist.config import load_voice_config
from voice_assist.intent.dialogue import Answered
from voice_assist.side_inputs import SideInputKind
from voice_assist.types import RATE, Call, Halt, Match, Mode, RejectionReason, SetMode


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_is_heard_once_also_without_early_decisions(command):
    assert commands(hear(command)) == [command]
    events = hear(command, recognizer__early__is_enabled=False)
    assert commands(events) == [command]
    assert not decisions(events)[0].is_partial


@pytest.mark.parametrize("command", COMMANDS)
def test_in_standby_only_hey_robot_and_stop_count(command):
    heard = commands(hear(command, Mode.STANDBY))
    assert heard == ([command] if command in ("hey robot", "stop") else [])


@pytest.mark.parametrize(
    "text",
    [
        "do not pull more",
        "never release",
        "pull",
        "pull more is what he said",
        "he said release",
        "tense what",
        "more pull",
        "do not stop",
        "please pull more",
        "pull more pull less",
    ],
)
def test_talk_that_holds_a_command_does_nothing(text):
    events = hear(text)
    assert commands(events) == []
    assert len(refusals(events)) == 1


def test_silence_gives_nothing_at_all():
    pipeline, clock = make()
    assert run(pipeline, clock, frames(silence(5.0).astype(np.float32))) == []


def test_stop_is_decided_before_the_word_has_faded():
    events = hear("stop")
    (decision,) = decisions(events)
    assert decision.is_partial
    assert decision.decided < 100.0 + 0.5 + 0.22 + 0.1
    assert decision.actions == (Halt(), Call("stop"))


@pytest.mark.parametrize(
    ("text", "taken"),
    [
        ("he said 0.6 stop 0.6 is what he said", ["stop"]),  # after a pause
        ("stop 0.1 pulling", ["stop"]),
        ("stop stop", ["stop"]),
        ("pull more 0.2 stop", ["pull more", "stop"]),  # in the same breath
        ("pull more 0.7 pull less", ["pull more", "pull less"]),
    ],
)
def test_a_stop_is_heard_once_and_after_a_command_as_another_command_after_a_pause(text, taken):
    assert commands(hear(text)) == taken


def test_another_command_in_the_same_breath_is_refused_with_a_reason():
    events = hear("pull more 0.25 pull less")
    assert commands(events) == ["pull more"]
    assert "pause before the next command" in refusals(events)[0].rejection.words


def test_a_motion_waits_for_a_short_pause_and_its_stamps_enclose_the_speech():
    (decision,) = decisions(hear("pull more"))
    assert decision.is_partial
    assert decision.speech_start == pytest.approx(100.5, abs=0.05)
    assert decision.speech_end == pytest.approx(100.5 + 0.47, abs=0.12)
    pause = load_voice_config().recognizer.early.pause
    assert decision.decided >= decision.speech_end + pause - 1e-6


def test_a_phrase_that_can_grow_waits_for_the_end_of_the_utterance():
    entries = command_entries()
    motion = next(entry for entry in entries if entry["phrase"] == "pull more")
    grown = {**motion, "phrase": "pull more please", "spellings": [], "threshold": 0.3}
    (decision,) = decisions(hear("pull more", commands__commands=[grown, *entries]))
    assert isinstance(decision.outcome, Match) and not decision.is_partial


def test_the_second_opinion_refuses_a_motion():
    events = hear("pull more", recognizer=FakeRecognizer({"pull more": -3.0}))
    assert commands(events) == []
    config = load_voice_config()
    worth, least = config.recognizer.confidence.scores(-3.0), config.commands.get("pull more")
    assert worth < 0.5
    words = f"confidence {worth:.2f}, allowed: at least {least.min_confidence:.2f}"
    assert words in refusals(events)[0].rejection.words


@pytest.mark.parametrize("text", ["pull more", "tense", "release", "pull less"])
def test_a_motion_that_the_decoder_only_guesses_is_refused_whatever_its_scores(text):
    least = load_voice_config().recognizer.motion_confidence
    events = hear(text, recognizer=FakeRecognizer(confidence=least - 0.01))
    assert commands(events) == []
    words = f"of the transcript, allowed: at least {least:.2f}"
    assert words in refusals(events)[0].rejection.words
    assert commands(hear(text, recognizer=FakeRecognizer(confidence=least + 0.01))) == [text]


@pytest.mark.parametrize("text", ["hey robot", "terminate", "stop"])
def test_what_moves_nothing_is_not_held_to_the_confidence_of_motions(text):
    config = load_voice_config()
    guessed = FakeRecognizer(confidence=config.recognizer.motion_confidence - 0.05)
    assert commands(hear(text, recognizer=guessed)) == [text]


def test_the_second_opinion_refuses_what_sounds_like_another_command():
    events = hear("pull more", recognizer=FakeRecognizer({"pull less": 21.0}))
    assert commands(events) == []
    assert "sounds more like 'pull less'" in refusals(events)[0].rejection.words


def test_an_unsure_stop_is_refused_at_the_end_and_says_so_but_never_by_the_second_opinion():
    assert commands(hear("stop", recognizer=FakeRecognizer({"stop": -99.0}))) == ["stop"]
    events = hear("stop", recognizer=FakeRecognizer(confidence=0.3))
    assert commands(events) == []
    assert refusals(events)[0].rejection.words.startswith("confidence 0.30, allowed: at least")
    assert refusals(events)[0].nearest_command == "stop"


def test_without_second_opinion_the_transcript_decides():
    for confidence, taken in ((0.95, ["pull more"]), (0.75, [])):
        recognizer = FakeRecognizer({"pull more": -9.0}, confidence=confidence)
        events = hear("pull more", recognizer=recognizer, recognizer__second_opinion=False)
        assert commands(events) == taken


def test_hey_robot_activates_and_terminate_puts_back():
    pipeline, clock = make(Mode.STANDBY)
    events = run(pipeline, clock, frames(say("hey robot 0.8 tense 0.8 terminate 0.8 tense")))
    assert commands(events) == ["hey robot", "tense", "terminate"]
    assert pipeline.state.mode is Mode.STANDBY
    first = decisions(events)[0]
    assert first.mode is Mode.STANDBY
    assert first.actions == (Call("hey robot"), SetMode(Mode.ACTIVE, "hey robot"))


def test_a_refusal_by_the_controller_is_written_into_the_mode():
    pipeline, clock = make(Mode.STANDBY)
    run(pipeline, clock, frames(say("hey robot")))
    (action,) = pipeline.answer(Answered("hey robot", False, "the robot is faulted"))
    assert action.mode is Mode.ACTIVE and "the robot is faulted" in action.reason


def test_the_same_sound_gives_the_same_decisions_again():
    pipeline, clock = make()
    sound = say("hey robot 0.8 tense 0.8 he said stop 0.5 stop 1.0 pull more 0.7 release")
    outcomes = []
    for _ in range(2):
        pipeline.reset()
        pipeline.set_mode(Mode.STANDBY, "test")
        found = decisions(run(pipeline, clock, frames(sound)))
        outcomes.append([(d.outcome, d.decided) for d in found])
    assert outcomes[0] == outcomes[1] and len(outcomes[0]) == 6


@pytest.mark.parametrize("mode", ["off", "endpointing_only", "on"])
def test_commands_are_heard_with_every_setting_of_noise_reduction(mode):
    heard = commands(hear("hey robot 0.8 tense", audio__denoise__mode=mode))
    assert heard == ["hey robot", "tense"]


@pytest.mark.parametrize("mode", ["off", "endpointing_only", "on"])
def test_the_spotter_hears_the_sound_as_it_came(mode):
    heard = []

    class Listening(FakeSpotting):
        def __call__(self, frame):
            heard.append(frame.samples)

    pipeline, clock = make(spotting=Listening(), audio__denoise__mode=mode)
    came = frames(say("0.3 tense"))
    run(pipeline, clock, came)
    np.testing.assert_array_equal(np.concatenate(heard), np.concatenate([f.samples for f in came]))


def test_no_first_consonant_is_lost():
    recognizer = FakeRecognizer()
    heard = []
    transcribe = recognizer.transcribe
    recognizer.transcribe = lambda samples, *_: heard.append(samples) or transcribe(samples)
    hear("tense", recognizer=recognizer)
    quiet = np.flatnonzero(np.abs(heard[-1]) > 0.01)[0] / RATE
    assert quiet > 0.2, "the pre-roll reaches back before the first loud sample"


@pytest.mark.parametrize("word", ["tense", "pull more", "release", "hey robot", "terminate"])
def test_while_the_talk_gate_is_closed_a_command_is_refused_and_a_stop_counts(word):
    noted = []
    pipeline, clock = make(observer=noted.append)
    pipeline.talk_changed(TalkChange(False, 0.0))
    events = run(pipeline, clock, frames(say(f"0.3 {word} 1.0 stop 1.0")))
    assert commands(events) == ["stop"]
    first = decisions(events)[0]
    assert first.rejection.reason is RejectionReason.TALK_GATE
    assert [n.is_open for n in noted if n.kind is SideInputKind.TALK] == [False]


def test_with_an_open_talk_gate_a_command_counts():
    pipeline, clock = make()
    pipeline.talk_changed(TalkChange(False, 0.0))
    pipeline.talk_changed(TalkChange(True, 1.0))
    assert commands(run(pipeline, clock, frames(say("0.3 pull more 1.0")))) == ["pull more"]


@pytest.mark.parametrize(("is_open", "taken"), [(True, ["pull more"]), (False, [])])
def test_the_talk_gate_counts_as_it_stands_once_the_clock_is_set_back(is_open, taken):
    pipeline, clock = make()
    quiet = frames(say("1.0"), start=100.0)
    pipeline.talk_changed(TalkChange(not is_open, 1.0))
    run(pipeline, clock, quiet)
    pipeline.talk_changed(TalkChange(is_open, clock.now))
    later = frames(say("pull more 1.0"), quiet[-1].next_sample, start=96.0)
    assert commands(run(pipeline, clock, later)) == taken
