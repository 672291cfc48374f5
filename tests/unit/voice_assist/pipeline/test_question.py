# SPDX-License-Identifier: BSD-3-Clause
"""A motion that is nearly sure is asked for once; "yes" does it, and all else drops it."""

import pytest

from tests.unit.voice_assist.support.fake_pipeline import (
    FakeSpotting,
    actions,
    commands,
    decisions,
    make,
    run,
)
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, say
from voice_assist.audio.robot_speech import RobotSpeechChange
from voice_assist.config import load_voice_config
from voice_assist.side_inputs import SideInputKind
from voice_assist.types import Ask, Call, Halt, Mode, RejectionReason

CONFIG = load_voice_config().recognizer
YES = "please"  # of the words that the fake recogniser knows
ASKS = {"recognizer__ask__is_enabled": True, "recognizer__ask__answer": YES}
BESIDE = {"moving__refuse_spotter": 1.0, "moving__spotter_alone": 3.0}
NEARLY = {"pull more": (CONFIG.ask.min_verification + CONFIG.motion_verification) / 2}
HARDLY = {"pull more": CONFIG.ask.min_verification - 0.1}
SURELY = {"pull more": CONFIG.motion_verification}
LIKE_TENSE = {"tense": 20.0}


def hear(text, odds=NEARLY, mode=Mode.ACTIVE, is_enabled=True, scores=None, **changes):
    changes |= {**ASKS, "recognizer__ask__is_enabled": is_enabled}
    made = make(mode, FakeRecognizer(scores, odds=odds), **changes)
    return run(*made, frames(say(text)))


def reasons(events):
    return [d.rejection.reason for d in decisions(events) if d.rejection is not None]


def test_yes_does_what_was_asked_for_once():
    events = hear(f"0.3 pull more 1.0 {YES}")
    assert actions(events) == [Ask("pull more"), Call("pull more")]
    asked, answered = decisions(events)
    assert asked.rejection.reason is RejectionReason.NEARLY_SURE
    assert asked.rejection.words.startswith(f'nearly sure; say "{YES}" within 3 s: ')
    assert (answered.command, answered.hypothesis.text) == ("pull more", YES)
    assert commands(hear(f"0.3 pull more 1.0 {YES} 0.8 {YES}")) == ["pull more"]


@pytest.mark.parametrize(
    "then", ["0.8 what", "0.8 {0} {0}", "0.8 {0} more", "0.8 he said {0}", "0.1 {0}", "3.2 {0}", ""]
)
def test_anything_else_drops_it(then):
    assert commands(hear(f"0.3 pull more {then.format(YES)}")) == []


def test_a_question_that_lapsed_does_not_stand_again_where_the_clock_is_set_back():
    pipeline, clock = make(Mode.ACTIVE, FakeRecognizer(odds=NEARLY), **ASKS)
    asked = frames(say("0.3 pull more 4.0"))
    assert actions(run(pipeline, clock, asked)) == [Ask("pull more")]
    back = 100.0 - 4.5  # [s]
    answer = frames(say(YES), asked[-1].next_sample, start=back)
    assert actions(run(pipeline, clock, answer)) == []


@pytest.mark.parametrize("other", ["what", "stop", "hey robot", "terminate", "more", "release"])
def test_after_anything_else_a_yes_does_nothing(other):
    heard = commands(hear(f"0.3 pull more 0.8 {other} 0.8 {YES}"))
    assert "pull more" not in heard
    assert heard == ([] if other in ("what", "more") else [other])


def test_what_is_nearly_sure_again_is_not_asked_for_again_but_later_it_may_be():
    events = hear(f"0.3 pull more 0.8 pull more 0.8 {YES}")
    assert actions(events) == [Ask("pull more")]
    assert reasons(events)[:2] == [RejectionReason.NEARLY_SURE, RejectionReason.UNSURE]
    assert actions(hear("0.3 pull more 4.0 pull more")) == 2 * [Ask("pull more")]


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"odds": HARDLY}, RejectionReason.SOUNDS_LIKE_ANOTHER),
        ({"mode": Mode.STANDBY}, RejectionReason.WRONG_MODE),
        ({"is_enabled": False}, RejectionReason.SOUNDS_LIKE_ANOTHER),
    ],
)
def test_what_is_hardly_like_it_is_not_asked_for_and_nothing_in_standby_or_where_none_is(
    changes, reason
):
    events = hear(f"0.3 pull more 0.8 {YES}", **changes)
    assert actions(events) == []
    assert reasons(events)[0] is reason


def test_what_is_sure_is_done_at_once():
    assert actions(hear("0.3 pull more", SURELY)) == [Call("pull more")]


def test_what_sounds_almost_like_a_motion_is_asked_for():
    events = hear(f"0.3 dense 1.0 {YES}", scores=LIKE_TENSE)
    assert actions(events) == [Ask("tense"), Call("tense")]
    words = decisions(events)[0].rejection.words
    assert words.endswith("WER 1.00 to 'tense', allowed below 0.50")


@pytest.mark.parametrize(
    ("said", "changes"),
    [
        ("dense", {"is_enabled": False}),
        ("dense", {"mode": Mode.STANDBY}),
        ("dense", {"scores": {}}),
        ("dense", {"scores": {**LIKE_TENSE, "release": 30.0}}),
        ("dense", {"odds": {"tense": HARDLY["pull more"]}}),
        ("dense", {"recognizer__ask__max_distance": 0.0}),
        ("dense", {"commands__said_twice": True}),
        ("dense dense", {}),
        ("do not dense", {}),
        ("he said dense", {}),
        ("the dense", {"recognizer__ask__max_distance": 0.1}),
        ("more", {}),
    ],
)
def test_what_sounds_less_like_a_motion_is_not_asked_for(said, changes):
    events = hear(f"0.3 {said} 0.8 {YES}", **{"scores": LIKE_TENSE, **changes})
    assert actions(events) == []


def test_what_sounds_almost_like_a_motion_is_asked_for_once_not_in_standby_and_a_stop_stops():
    events = hear("0.3 dense", mode=Mode.STANDBY, scores=LIKE_TENSE)
    assert reasons(events) == [RejectionReason.NO_COMMAND]
    events = hear(f"0.3 dense 0.8 dense 0.8 {YES}", scores=LIKE_TENSE)
    assert actions(events) == [Ask("tense")]
    assert commands(hear("0.3 dense 0.8 stop", scores=LIKE_TENSE)) == ["stop"]


def test_a_doubtful_confidence_is_asked_for_too():
    changes = {"recognizer__second_opinion": False, "recognizer__ask__min_confidence": 0.8}
    events = hear(f"0.3 tense 1.0 {YES}", {}, **changes)
    assert actions(events) == [Ask("tense"), Call("tense")]


@pytest.mark.parametrize("word", ["stop", "hey robot", "terminate"])
def test_what_is_no_motion_is_never_asked_for(word):
    events = hear(f"0.3 {word} 0.8 {YES}", {word: NEARLY["pull more"]})
    assert not [action for action in actions(events) if isinstance(action, Ask)]


def ask_by_hand(after="0.8", **changes):
    """A pipeline that has just asked for "pull more", what is noted, and lets hear what follows."""
    noted, recognizer = [], FakeRecognizer(odds=NEARLY)
    pipeline, clock = make(recognizer=recognizer, observer=noted.append, **ASKS, **changes)
    sound = iter(frames(say(f"0.3 pull more {after} 0.5")))
    while not actions(run(pipeline, clock, [next(sound)])):
        pass
    return pipeline, noted, lambda: run(pipeline, clock, sound)


def by_hand(noted):
    return [(n.command, n.is_accepted) for n in noted if n.kind is SideInputKind.BY_HAND]


def test_an_answer_by_hand_does_it_once_and_is_noted():
    pipeline, noted, _ = ask_by_hand()
    assert pipeline.answer_by_hand("pull more", True) == (Call("pull more"),)
    assert pipeline.answer_by_hand("pull more", True) is None
    assert by_hand(noted) == [("pull more", True)]


def test_a_no_by_hand_drops_it_for_the_voice_too():
    pipeline, noted, hear_on = ask_by_hand(f"0.8 {YES}")
    assert pipeline.answer_by_hand("pull more", False) == ()
    assert commands(hear_on()) == []
    assert by_hand(noted) == [("pull more", False)]


@pytest.mark.parametrize("command", ["pull less", "tense", "", "nonsense"])
def test_another_answer_by_hand_than_to_the_question_does_nothing(command):
    pipeline, noted, _ = ask_by_hand()
    assert pipeline.answer_by_hand(command, True) is None
    assert by_hand(noted) == []


def test_an_answer_by_hand_that_comes_late_or_after_a_change_of_mode_does_nothing():
    pipeline, noted, hear_on = ask_by_hand("4.0")
    hear_on()
    assert pipeline.answer_by_hand("pull more", True) is None
    assert by_hand(noted) == []
    pipeline, _, _ = ask_by_hand()
    pipeline.set_mode(Mode.STANDBY, "test")
    assert pipeline.answer_by_hand("pull more", True) is None


@pytest.mark.parametrize(
    ("said", "done"),
    [
        ("0.3 pull more", [Ask("pull more")]),
        ("0.3 pull more 1.0 pull more", [Ask("pull more"), Call("pull more")]),
        ("0.3 pull more 3.4 pull more", [Ask("pull more")] * 2),
        ("0.3 pull more 1.0 pull less", [Ask("pull more"), Ask("pull less")]),
        ("0.3 pull more 0.8 what 0.8 pull more", [Ask("pull more")] * 2),
        ("0.3 pull more 0.8 please", [Ask("pull more"), Call("pull more")]),
        (
            "0.3 pull more 1.0 pull more 1.0 pull more",
            [Ask("pull more"), Call("pull more"), Ask("pull more")],
        ),
    ],
)
def test_where_motions_are_said_twice_the_same_one_again_does_it(said, done):
    events = hear(said, odds=None, is_enabled=False, commands__said_twice=True)
    assert actions(events) == done


@pytest.mark.parametrize("said", ["stop", "terminate", "hey robot"])
def test_what_is_no_motion_is_said_once(said):
    events = hear(f"0.3 {said}", odds=None, is_enabled=False, commands__said_twice=True)
    assert commands(events) == [said]


def test_after_a_change_of_mode_at_the_robot_no_answer_does_it():
    pipeline, noted, hear_on = ask_by_hand(f"0.8 {YES}")
    pipeline.follow(Mode.ACTIVE)  # as it is reported all the time
    pipeline.follow(Mode.STANDBY)
    pipeline.follow(Mode.ACTIVE)
    assert pipeline.answer_by_hand("pull more", True) is None
    assert commands(hear_on()) == []
    assert by_hand(noted) == []


@pytest.mark.parametrize("score", [0.9, 1.5, 3.5])
def test_a_stop_beside_the_answer_counts_as_beside_a_motion(score):
    spotting = FakeSpotting(0.0)
    _, _, hear_on = ask_by_hand(f"0.8 {YES}", spotting=spotting, **BESIDE)
    spotting.score = score
    heard = hear_on()
    if score < 1.0:
        assert commands(heard) == ["pull more"]
    elif score < 3.0:
        assert commands(heard) == [] and reasons(heard) == [RejectionReason.SECOND_VOICE]
    else:
        assert commands(heard) == ["stop"]


@pytest.mark.parametrize(
    ("score", "done"), [(0.9, [Ask("tense")]), (1.5, []), (3.5, [Halt(), Call("stop")])]
)
def test_a_stop_beside_what_sounds_almost_like_a_motion_counts_as_beside_one(score, done):
    events = hear("0.3 dense 0.5", None, scores=LIKE_TENSE, spotting=FakeSpotting(score), **BESIDE)
    assert actions(events) == done


# People learn of it only later, as recognition takes its time.


@pytest.mark.parametrize(("late", "is_done"), [(0.0, False), (0.5, False), (1.5, True)])
def test_the_time_of_a_question_begins_when_people_learn_of_it(late, is_done):
    pipeline, noted, hear_on = ask_by_hand(f"4.0 {YES}")
    asked = pipeline._heard_until
    pipeline.question_shown(asked + late)
    assert commands(hear_on()) == (["pull more"] if is_done else [])
    assert [n.time for n in noted if n.kind is SideInputKind.ASKED] == [asked + late]


def test_what_was_dropped_before_people_learn_of_it_stays_dropped():
    pipeline, _, hear_on = ask_by_hand(f"0.8 {YES}")
    pipeline.answer_by_hand("pull more", False)
    pipeline.question_shown(pipeline._heard_until + 1.0)
    assert commands(hear_on()) == []


# The robot speaks of it, and the microphone hears that.


def over_own_voice(text, *reports, **changes):
    """A sentence, in which it is reported when the robot's own voice begins and ends [s]."""
    pipeline, clock = make(Mode.ACTIVE, FakeRecognizer(odds=NEARLY), **ASKS, **changes)
    heard, waiting, events = frames(say(text), start=0.0), list(reports), []
    for frame in heard:
        while waiting and waiting[0][0] <= frame.stamp:
            at, is_speaking = waiting.pop(0)
            pipeline.robot_spoke(RobotSpeechChange(is_speaking, at))
        events += run(pipeline, clock, [frame])
    return events


OWN = "0.3 pull more 0.9 what"  # said by a person, then by the robot
SPOKEN = (1.7, True), (2.3, False)


@pytest.mark.parametrize(("pause", "counts"), [("1.2", True), ("3.2", True), ("4.5", False)])
def test_its_own_voice_is_no_answer_and_the_time_for_one_begins_behind_it(pause, counts):
    events = over_own_voice(f"{OWN} {pause} {YES}", *SPOKEN)
    assert actions(events) == [Ask("pull more"), *[Call("pull more")] * counts]


def test_what_a_person_says_behind_its_voice_drops_the_question():
    assert commands(over_own_voice(f"{OWN} 1.2 what 0.8 {YES}", *SPOKEN)) == []


def test_a_stop_over_its_voice_drops_the_question():
    events = over_own_voice(f"0.3 pull more 0.9 stop 1.2 {YES}", *SPOKEN)
    assert commands(events) == ["stop"]


def test_a_question_waits_for_its_voice_only_once():
    again = (5.0, True), (5.2, False)
    assert commands(over_own_voice(f"{OWN} 4.5 {YES}", *SPOKEN, *again)) == []
