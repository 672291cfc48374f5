# SPDX-License-Identifier: BSD-3-Clause
"""What was meant beside what it was taken for, also where nothing or too much was taken."""

import pytest

from session_log.mcap_file.summary import RecordingSummary
from session_log.report.session.extract import extract
from session_log.report.session.session_data import IntendedPhrase, RecordedUtterance, SessionData
from session_log.report.session.trials import (
    NO_COMMAND,
    NOT_SAID,
    NOTHING,
    OTHER,
    PhraseTrial,
    trials,
)
from support.story import Story, recording_of

COMMANDS = ("hey robot", "tense", "pull more", "stop")


def heard(start, transcript, command=""):
    end = start + 0.5
    return RecordedUtterance(start, end, end + 0.2, transcript, command, "", "", 0.0, False)


def judge(config, intended, said, phrases=COMMANDS):
    data = SessionData(RecordingSummary(None), said, phrases=phrases)
    data.intended = [IntendedPhrase(time, phrase) for time, phrase in intended]
    return [(t.intended, t.taken) for t in trials(data, config)]


@pytest.mark.parametrize(
    ("phrase", "said", "expected"),
    [
        ("tense", [heard(1.1, "tense", "tense")], ("tense", "tense")),
        ("tense", [], ("tense", NOTHING)),
        ("tense", [heard(1.1, "")], ("tense", NOTHING)),
        ("tense", [heard(1.1, "dense")], ("tense", OTHER)),
        ("tense", [heard(1.1, "stop", "stop")], ("tense", "stop")),
        ("", [heard(1.1, "pass me the clamp")], (NO_COMMAND, OTHER)),
        ("", [heard(1.1, "stop", "stop")], (NO_COMMAND, "stop")),
        ("", [], (NO_COMMAND, NOTHING)),
        ("pull", [heard(1.1, "pull")], (NO_COMMAND, OTHER)),  # no command has this phrase
    ],
)
def test_one_phrase_is_judged(report_config, phrase, said, expected):
    assert judge(report_config, [(1.0, phrase)], said) == [expected]


@pytest.mark.parametrize(
    ("meant", "taken", "right"),
    [
        ("tense", "tense", True),
        ("tense", "stop", False),
        ("tense", NOTHING, False),
        ("tense", OTHER, False),
        (NO_COMMAND, OTHER, True),
        (NO_COMMAND, NOTHING, True),
        (NO_COMMAND, "tense", False),
        (NOT_SAID, "stop", False),
    ],
)
def test_right_is_the_command_meant_and_none_where_none_was(meant, taken, right):
    assert PhraseTrial(0.0, meant, taken, "").is_correct is right


def test_speech_belongs_to_the_phrase_that_last_began(report_config):
    intended = [(1.0, "pull more"), (2.4, "stop")]
    said = [heard(1.1, "pull more", "pull more"), heard(2.5, "stop", "stop")]
    expected = [("pull more", "pull more"), ("stop", "stop")]
    assert judge(report_config, intended, said) == expected


def test_speech_may_be_stamped_a_little_before_its_phrase(report_config):
    early = 1.0 - report_config.intended_slack / 2
    assert judge(report_config, [(1.0, "tense")], [heard(early, "tense", "tense")]) == [
        ("tense", "tense")
    ]


@pytest.mark.parametrize("late", [False, True])
def test_a_command_that_nobody_said_counts_against_the_recogniser(report_config, late):
    start = 1.0 + report_config.intended_window + 0.5 if late else 0.2
    found = judge(report_config, [(1.0, "tense")], [heard(start, "stop", "stop")])
    assert sorted(found) == sorted([("tense", NOTHING), (NOT_SAID, "stop")])


def test_talk_that_is_no_command_and_that_nobody_announced_is_no_trial(report_config):
    said = [heard(0.2, "where is the nurse"), heard(30.0, "thank you")]
    assert judge(report_config, [(1.0, "tense")], said) == [("tense", NOTHING)]


def test_the_first_command_counts_and_a_different_second_one_is_an_error(report_config):
    said = [heard(1.1, "stop", "stop"), heard(1.8, "hey robot", "hey robot")]
    found = judge(report_config, [(1.0, "tense")], said)
    assert sorted(found) == [(NOT_SAID, "hey robot"), ("tense", "stop")]


def test_the_same_command_heard_twice_is_one_trial(report_config):
    said = [heard(1.1, "stop", "stop"), heard(1.2, "stop", "stop")]
    assert judge(report_config, [(1.0, "stop")], said) == [("stop", "stop")]


def test_a_session_that_does_not_know_what_was_meant_has_no_trials(report_config):
    assert judge(report_config, [], [heard(1.1, "stop", "stop")]) == []


@pytest.mark.parametrize(
    ("phrase", "expected"), [("tirer plus", ("tirer plus", NOTHING)), ("", (NO_COMMAND, NOTHING))]
)
def test_where_nothing_was_heard_what_was_shown_was_meant_in_any_language(
    report_config, phrase, expected
):
    assert judge(report_config, [(1.0, phrase)], [], phrases=()) == [expected]


def test_where_the_commands_are_known_other_words_are_none(report_config):
    assert judge(report_config, [(1.0, "tirer plus")], []) == [(NO_COMMAND, NOTHING)]


def test_a_command_of_before_the_commands_were_changed_was_meant(tmp_path, report_config):
    story = Story()
    for time, phrases, command in (
        (1.0, ["licht an", "stop"], "licht an"),
        (11.0, ["light on", "stop"], "light on"),
        (21.0, ["light on", "stop"], ""),
    ):
        said = command or "clamp"
        times = {"speech_start": time + 0.1, "speech_end": time + 0.5, "decision": time + 0.7}
        fields = {"phrases": phrases, "wer": [0.0, 1.0], "command": command, "transcript": said}
        story.say(time, "/voice_assist/intended", "std_msgs/String", data=said)
        kind = "voice_assist/Utterance"
        story.say(time + 0.7, "/voice_assist/utterance", kind, **fields, **times)
    data = extract(recording_of(tmp_path / "s.mcap", story.messages), report_config)
    found = [(t.intended, t.taken) for t in trials(data, report_config)]
    assert found == [("licht an", "licht an"), ("light on", "light on"), (NO_COMMAND, OTHER)]
