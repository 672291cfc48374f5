# SPDX-License-Identifier: BSD-3-Clause
import json
from dataclasses import replace

import pytest

from tests.unit.voice_assist.display.support.theatre import (
    HALTED,
    PULLING,
    RULES,
    TISSUE,
    Clock,
    make_theatre,
)
from voice_assist.display.access_token import FREE_TRIES, LENGTH, WAIT, AccessToken
from voice_assist.display.encoding import event
from voice_assist.display.phase_clock import PhaseClock
from voice_assist.display.snapshot import Picture, UtterancePart
from voice_assist.display.theatre import DEVICE_FOR, OWN_VOICE_FOR, PARTIAL_FOR, QUIET, Theatre
from voice_assist.display.words import words_that_count


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def theatre(clock):
    return make_theatre(clock)


def test_nothing_is_known_of_what_was_never_heard(clock):
    snapshot = Theatre(0.5, clock, clock).snapshot()
    assert (snapshot.robot, snapshot.tissue, snapshot.hearing, snapshot.recording) == (None,) * 4
    assert (snapshot.alarm, snapshot.picture) == (None,) * 2


def test_each_part_ages_by_itself_and_a_voice_without_sound_has_no_age(theatre, clock):
    clock.now += 3.0
    theatre.see_sound(-20.0)
    snapshot = theatre.snapshot()
    assert snapshot.robot.age == snapshot.tissue.age == snapshot.recording.age == 3.0
    assert (snapshot.hearing.age, snapshot.hearing.utterance.age) == (0.0, 3.0)
    theatre = Theatre(0.5, clock, clock)
    theatre.see_voice_health("", "no sound has come yet")
    hearing = theatre.snapshot().hearing
    assert (hearing.age, hearing.trouble) == (float("inf"), "no sound has come yet")


@pytest.mark.parametrize(
    ("stamps", "age"), [((7.0, 7.0), 1.0), ((7.0, 7.02), 0.0), ((7.0, 5.0), 0.0), ((0.0, 0.0), 0.0)]
)
def test_what_comes_again_with_the_stamp_it_had_is_no_news(clock, stamps, age):
    """A loop that hangs is reported on and on; a camera's last picture may be sent again."""
    theatre = Theatre(0.5, clock, clock)
    for stamp in stamps:
        clock.now += 1.0
        theatre.see_robot(PULLING, TISSUE, stamp)
        theatre.see_picture("image/png", b"one", stamp)
    snapshot = theatre.snapshot()
    assert (snapshot.robot.age, snapshot.tissue.age, snapshot.picture.age) == (age,) * 3
    assert snapshot.steady == clock.now


def test_the_level_is_the_loudest_since_the_last_snapshot(theatre):
    for levels, loudest in (((-50.0, -12.0, -40.0), -12.0), ((), QUIET), ((-44.0,), -44.0)):
        for level in levels:
            theatre.see_sound(level)
        assert theatre.snapshot().hearing.level == loudest


def asked(theatre):
    """What the page asks for, and for how long still [s]."""
    question = theatre.snapshot().hearing.question
    return None if question is None else (question.command, question.remaining)


def test_a_question_stands_while_the_robot_itself_speaks_and_its_time_begins_behind(theatre, clock):
    theatre.answer_within = 3.0
    nothing = replace(theatre.snapshot().hearing.utterance, command="")
    theatre.see_speaking(False)  # of before
    theatre.see_utterance(nothing, "pull more")
    theatre.see_speaking(True)
    clock.now += 1.0
    theatre.see_utterance(nothing)  # its own words
    assert asked(theatre) == ("pull more", 2.0)
    theatre.see_speaking(False)
    theatre.see_utterance(nothing)
    assert asked(theatre) == ("pull more", 3.0)
    clock.now += 2.0
    for is_speaking in (True, False):  # once more
        theatre.see_speaking(is_speaking)
    assert asked(theatre) == ("pull more", 1.0)
    clock.now += OWN_VOICE_FOR + 0.1
    theatre.see_utterance(nothing)
    assert asked(theatre) is None


@pytest.mark.parametrize("command", ["stop", "tense"])
def test_a_command_over_its_voice_ends_the_question(theatre, command):
    theatre.answer_within = 3.0
    nothing = replace(theatre.snapshot().hearing.utterance, command="")
    theatre.see_utterance(nothing, "pull more")
    theatre.see_speaking(True)
    theatre.see_utterance(replace(nothing, command=command))
    assert asked(theatre) is None


def test_a_question_that_has_lapsed_does_not_come_back(theatre, clock):
    theatre.answer_within = 3.0
    theatre.see_utterance(replace(theatre.snapshot().hearing.utterance, command=""), "pull more")
    theatre.see_speaking(True)
    clock.now += 3.1
    theatre.see_speaking(False)
    assert asked(theatre) is None


@pytest.mark.parametrize(
    ("part", "text", "shown_for"),
    [("partial", "pull m", PARTIAL_FOR), ("device", "light on: done", DEVICE_FOR)],
)
def test_text_as_it_is_heard_and_what_a_device_answered_go_with_the_next_word_or_with_time(
    theatre, clock, part, text, shown_for
):
    def shown():
        return getattr(theatre.snapshot().hearing, part)

    see = getattr(theatre, f"see_{part}")
    theatre.see_utterance(UtterancePart("light on", "light on", "", "recognizer"))
    see(text)
    assert shown() == text
    theatre.see_utterance(UtterancePart("pull more", "pull more", "", "recognizer"))
    assert shown() == ""
    see(text)
    clock.now += shown_for
    assert shown() == ""


@pytest.mark.parametrize(
    ("before", "is_rest", "shown"),
    [("stop", True, "stop"), ("stop", False, ""), ("", True, "")],
)
def test_the_rest_of_a_stop_takes_no_place_of_it(theatre, before, is_rest, shown):
    theatre.see_utterance(UtterancePart("stop", before, "", "spotter"))
    theatre.see_utterance(UtterancePart("up", "", "it continues a stop", ""), is_rest=is_rest)
    utterance = theatre.snapshot().hearing.utterance
    assert utterance.command == shown and (utterance.transcript == "up") is (not shown)


def test_limits_and_why_the_tension_is_invalid_are_shown_with_it(theatre):
    theatre.see_tension_invalid("stuck")
    tissue = theatre.snapshot().tissue
    assert (tissue.tension_limit, tissue.rcm_limit) == (2.4, 1e-3)
    assert tissue.invalid_reason == "stuck"


@pytest.mark.parametrize(
    ("robot", "controller", "shown"),
    [
        ("", "", ""),
        ("", "tension.source is none", "tension.source is none"),
        ("stuck", "", "stuck"),
    ],
)
def test_the_tension_is_valid_where_neither_robot_nor_controller_objects(
    theatre, robot, controller, shown
):
    theatre.see_tension_invalid(robot)
    theatre.see_tension_distrust(controller)
    assert theatre.snapshot().tissue.invalid_reason == shown


def test_a_recording_counts_from_its_begin_and_not_from_when_it_became_known(theatre, clock):
    file = theatre.snapshot().recording.file
    clock.now += 3.0
    assert theatre.snapshot().recording.since == 3.0
    theatre.see_recorded_for("/sessions/another/session.mcap", 7200.0)
    assert theatre.snapshot().recording.since == 3.0
    theatre.see_recorded_for(file, 3600.0)
    clock.now += 1.0
    theatre.see_recorded_for(file, 3600.5)  # came late: time does not go back
    assert theatre.snapshot().recording.since == 3601.0
    theatre.see_file("/sessions/another/session.mcap")
    assert theatre.snapshot().recording.since == 0.0


def test_pictures_are_numbered(theatre):
    theatre.see_picture("image/png", b"one", 1.0)
    theatre.see_picture("image/jpeg", b"two", 2.0)
    assert theatre.snapshot().picture.number == theatre.picture.number == 2
    assert theatre.picture == Picture(2, "image/jpeg", b"two", 2.0)


def test_words_count_by_mode_state_and_what_is_held(theatre):
    cases = {
        ("standby", "standby", False): ("hey robot", "stop"),
        ("active", "active", False): ("hey robot", "tense", "stop"),
        ("active", "active", True): ("hey robot", "release", "pull more", "pull less", "stop"),
        ("active", "moving", True): ("hey robot", "pull more", "pull less", "stop"),
        ("active", "halted", True): ("hey robot", "stop"),
        ("", "active", True): (),
    }
    for (mode, state, held), expected in cases.items():
        assert words_that_count(RULES, mode, state, held) == expected
    assert "pull more" in theatre.snapshot().robot.words
    theatre.see_robot(HALTED, TISSUE)
    assert theatre.snapshot().robot.words == ("hey robot", "stop")


@pytest.mark.parametrize(
    "then",
    [
        [("pull", 0.4, 3.0), ("release", 0.0, 3.1)],  # it stands; the next phase
        [("pull", 0.1, 1.1)],  # the same one again
    ],
)
def test_a_phase_ends_as_its_speed_lately_says_and_each_begins_anew(then):
    phase = PhaseClock()
    for step in range(11):
        phase.report("pull", 0.04 * step, 0.1 * step)
    assert phase.remaining == pytest.approx(1.5)
    for news in then:
        phase.report(*news)
        assert phase.remaining is None


def test_the_remaining_time_is_shown_of_what_moves_only(theatre, clock):
    for step in range(5):
        clock.now += 0.1
        theatre.see_robot(replace(PULLING, progress=0.5 + 0.05 * step), TISSUE)
    assert theatre.snapshot().robot.remaining == pytest.approx(0.5)
    theatre.see_robot(replace(HALTED, phase="pull", progress=0.7), TISSUE)
    assert theatre.snapshot().robot.remaining is None


def test_an_event_is_one_line_of_json_without_what_is_no_number(theatre):
    theatre.see_robot(PULLING, replace(TISSUE, tension=float("nan"), rcm_error=float("inf")))
    theatre.see_partial('pull\n\ndata: {"robot":null} \u2028')
    text = event(theatre.snapshot())
    assert text.startswith(b"data: {") and text.endswith(b"}\n\n")
    assert text.count(b"\n") == 2 and text.isascii()
    data = json.loads(text.removeprefix(b"data: "))
    assert data["tissue"]["tension"] is None and data["tissue"]["rcm_error"] is None
    assert data["hearing"]["partial"].startswith("pull\n")
    assert data["robot"]["words"][0] == "hey robot"


def test_tokens_differ_and_are_taken_as_a_person_types_them(clock):
    token = AccessToken(clock)
    assert len(token.text) == LENGTH and token.text != AccessToken(clock).text
    assert token.admits(f" {token.text.lower()} ")
    assert not token.admits("") and not token.admits("\udcff" + token.text)


def test_guessing_tokens_takes_a_wait_each(clock):
    token = AccessToken(clock)
    for _ in range(FREE_TRIES):
        assert not token.is_locked
        assert not token.admits("wrong")
    assert token.is_locked and not token.admits(token.text)
    clock.now += WAIT
    assert not token.admits("wrong")
    assert token.is_locked
    clock.now += WAIT
    assert token.admits(token.text) and not token.is_locked
