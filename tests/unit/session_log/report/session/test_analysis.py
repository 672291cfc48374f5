# SPDX-License-Identifier: BSD-3-Clause
import math
from dataclasses import replace

import numpy as np
import pytest

from session_log.mcap_file.summary import RecordingSummary
from session_log.report.session import analysis
from session_log.report.session.session_data import (
    Intervals,
    RecordedEvent,
    RecordedUtterance,
    SessionData,
    Span,
)


def heard(command, end, decision, transcript=None):
    words = command if transcript is None else transcript
    return RecordedUtterance(end - 0.5, end, decision, words, command, "", command, 0.0, False)


def session(heard=(), events=(), states=()):
    return SessionData(RecordingSummary(None), list(heard), list(events), states=list(states))


def rows_of(config, *parts):
    return analysis.command_rows(session(*parts), config)


def test_the_commands_are_listed_in_order(data, report_config):
    rows = analysis.command_rows(data, report_config)
    assert [row.command for row in rows] == [
        "hey robot",
        "tense",
        "pull more",
        "pull more",
        "pull less",
        "tense",
        "pull more",
        "stop",
        "hey robot",
        "release",
        "terminate",
    ]
    assert [row.outcome for row in rows].count("refused") == 1
    assert rows[5].message == "tissue is held already" and rows[5].action is None
    assert all(row.action is not None for row in rows if row.outcome == "accepted")


def test_latency_runs_from_the_end_of_speech_to_the_start_of_motion(report_config):
    events = [
        RecordedEvent(10.31, "accepted", "tense", "ok"),
        RecordedEvent(10.42, "motion_started", "tense", ""),
    ]
    (row,) = rows_of(report_config, [heard("tense", 10.0, 10.3)], events)
    assert row.decision_latency == pytest.approx(0.3)
    assert row.action_latency == pytest.approx(0.42)


@pytest.mark.parametrize(
    ("caller", "by"),
    [
        ("/pedal", "pedal"),
        ("/rosservice_812_1764", "rosservice"),
        ("", "hand"),
        ("/voice", "/voice"),  # a node of that name; nothing was said
    ],
)
def test_what_is_pressed_is_timed_from_its_answer(report_config, caller, by):
    events = [
        RecordedEvent(10.31, "accepted", "tense", "ok", caller=caller),
        RecordedEvent(10.33, "motion_started", "tense", ""),
    ]
    (row,) = rows_of(report_config, [], events)
    assert (row.command, row.heard, row.given_by, row.action) == ("tense", None, by, 10.33)
    assert row.reaction == pytest.approx(0.02)
    assert math.isnan(row.action_latency)


def test_what_is_called_otherwise_than_it_is_said_is_joined_by_who_called(report_config):
    said, called = "pull two millimetres more", "pull more 2 mm"
    spoken = replace(heard(said, 10.0, 10.3), publisher="/voice_assist")
    others = RecordedEvent(10.305, "accepted", "pull less", "by hand", caller="/hand")
    events = [
        others,
        RecordedEvent(10.31, "accepted", called, "ok", caller="/voice_assist"),
        RecordedEvent(10.42, "motion_started", called, ""),
    ]
    row, by_hand = rows_of(report_config, [spoken], events)
    assert (row.command, row.outcome, row.message) == (said, "accepted", "ok")
    assert row.action_latency == pytest.approx(0.42)
    assert (by_hand.command, by_hand.heard, by_hand.caller) == ("pull less", None, "/hand")


def test_an_answer_to_another_phrase_of_the_same_voice_is_not_taken_from_it(report_config):
    light = replace(heard("light on", 10.0, 10.3), publisher="/voice_assist")
    more = replace(heard("pull more", 10.6, 10.7), publisher="/voice_assist")
    events = [RecordedEvent(10.71, "accepted", "pull more", "ok", caller="/voice_assist")]
    data = session([light, more], events)
    data.phrases = ("light on", "pull more")
    rows = analysis.command_rows(data, report_config)
    assert [(r.command, r.outcome) for r in rows] == [
        ("light on", "no answer"),
        ("pull more", "accepted"),
    ]


def test_a_second_word_for_a_command_has_the_answer_to_that_command(report_config):
    voice = "/voice_assist"
    said = [replace(heard("halt", 5.0, 5.3), publisher=voice), heard("stop", 8.0, 8.3)]
    events = [
        RecordedEvent(4.9, "stop_received", "stop", "", caller=voice),
        RecordedEvent(5.31, "stop_received", "stop", "", caller=voice),
        RecordedEvent(8.31, "stop_received", "stop", "", caller=voice),
    ]
    data = session(said, events)
    data.phrases = ("stop", "halt")
    data.called = {"stop": "stop", "halt": "stop"}
    rows = analysis.command_rows(data, report_config)
    assert [(r.command, r.outcome, r.heard, r.action) for r in rows] == [
        ("halt", "accepted", said[0], 4.9),
        ("stop", "accepted", said[1], 8.31),
    ]


def test_a_phrase_that_is_called_by_one_word_has_no_answer_to_another(report_config):
    spoken = replace(heard("straffen", 1.0, 1.2), publisher="/voice_assist")
    events = [RecordedEvent(1.3, "accepted", "release", "", caller="/voice_assist")]
    data = session([spoken], events)
    data.called = {"straffen": "tense", "lockern": "release"}
    rows = analysis.command_rows(data, report_config)
    assert [(r.command, r.outcome) for r in rows] == [
        ("straffen", "no answer"),
        ("release", "accepted"),
    ]


def test_the_answer_to_another_phrase_is_none_to_one_with_an_amount(report_config):
    spoken = replace(heard("pull two millimetres more", 1.0, 1.2), publisher="/voice_assist")
    events = [RecordedEvent(1.3, "accepted", "release", "", caller="/voice_assist")]
    data = session([spoken], events)
    data.called = {"let go": "release"}
    rows = analysis.command_rows(data, report_config)
    assert [r.outcome for r in rows] == ["no answer", "accepted"]


def test_a_stop_acts_when_it_is_received_and_counts_once_by_both_ways(report_config):
    events = [
        RecordedEvent(5.26, "stop_received", "", "by topic"),
        RecordedEvent(5.27, "stop_received", "stop", "by service"),
        RecordedEvent(5.6, "at_rest", "stop", ""),
    ]
    (row,) = rows_of(report_config, [heard("stop", 5.0, 5.25)], events)
    assert (row.command, row.action) == ("stop", 5.26)


def test_a_stop_that_a_spotter_sends_within_the_word_is_that_word(report_config):
    events = [
        RecordedEvent(4.9, "stop_received", "stop", "stopped by voice", caller="/voice_assist"),
        RecordedEvent(5.31, "stop_received", "stop", "by topic", caller="/voice_assist"),
        RecordedEvent(5.32, "stop_received", "stop", "by service", caller="/voice_assist"),
    ]
    (row,) = rows_of(report_config, [heard("stop", 5.0, 5.3)], events)
    assert row.heard is not None and row.action == 4.9
    assert row.decision_latency == row.action_latency == pytest.approx(-0.1)


@pytest.mark.parametrize(("time", "caller"), [(4.9, "/pedal"), (4.2, "/voice_assist")])
def test_a_stop_of_another_or_before_the_word_is_another_stop(report_config, time, caller):
    events = [
        RecordedEvent(time, "stop_received", "stop", "", caller=caller),
        RecordedEvent(5.31, "stop_received", "stop", "", caller="/voice_assist"),
    ]
    rows = rows_of(report_config, [heard("stop", 5.0, 5.3)], events)
    assert [(row.heard is None, row.action, row.caller) for row in rows] == [
        (True, time, caller),
        (False, 5.31, "/voice_assist"),
    ]


@pytest.mark.parametrize(
    ("kind", "words", "outcome"),
    [("accepted", "/light", "accepted"), ("refused", "/light, dark", "failed")],
)
def test_what_a_device_answers_is_the_answer_to_its_word(report_config, kind, words, outcome):
    data = session([heard("light on", 1.0, 1.2)])
    data.device_calls.append(RecordedEvent(1.3, kind, "light on", words, caller="devices"))
    (row,) = analysis.command_rows(data, report_config)
    assert (row.outcome, row.message, row.caller) == (outcome, words, "devices")
    assert math.isnan(row.action_latency) == (outcome == "failed")


def rows_of_calls(config, decisions, answers):
    """Decision and answer of each row: of words at some times, and of what a device answered."""
    data = session([heard("light on", time - 0.3, time) for time in decisions])
    data.device_calls += [
        RecordedEvent(time, "refused", "light on", f"at {time}", caller="devices")
        for time in answers
    ]
    rows = analysis.command_rows(data, config)
    return [(r.heard.decision if r.heard else None, r.answered) for r in rows]


@pytest.mark.parametrize(
    ("decisions", "answers", "rows"),
    [
        ([1.0], [3.004], [(1.0, 3.004)]),  # failed after its two seconds
        ([1.0], [61.0], [(1.0, 61.0)]),
        ([1.0, 2.0], [3.0, 5.0], [(1.0, 3.0), (2.0, 5.0)]),  # one call after the other
        ([1.0, 2.5], [2.8], [(1.0, None), (2.5, 2.8)]),  # the first has no answer
        ([1.0], [1.2, 9.0], [(1.0, 1.2), (None, 9.0)]),  # later a stop undid something
        ([2.0], [1.0], [(None, 1.0), (2.0, None)]),
    ],
)
def test_a_device_may_take_its_time_to_answer(report_config, decisions, answers, rows):
    assert rows_of_calls(report_config, decisions, answers) == rows


def test_a_refusal_has_no_action(report_config):
    events = [RecordedEvent(1.1, "refused", "release", "nothing grasped")]
    (row,) = rows_of(report_config, [heard("release", 0.8, 1.0)], events)
    assert (row.outcome, row.message) == ("refused", "nothing grasped")
    assert math.isnan(row.action_latency)


def test_a_command_that_the_controller_never_answered_is_reported(report_config):
    (row,) = rows_of(report_config, [heard("tense", 0.8, 1.0)], [])
    assert (row.outcome, row.action) == ("no answer", None)


def test_an_answer_long_after_the_decision_belongs_to_someone_else(report_config):
    events = [RecordedEvent(9.0, "accepted", "tense", "")]
    rows = rows_of(report_config, [heard("tense", 0.8, 1.0)], events)
    assert [(r.heard is not None, r.outcome) for r in rows] == [
        (True, "no answer"),
        (False, "accepted"),
    ]


def test_two_commands_by_hand_at_once_are_two(report_config):
    events = [
        RecordedEvent(1.0, "refused", "tense", "halted"),
        RecordedEvent(1.05, "accepted", "hey robot", ""),
    ]
    rows = rows_of(report_config, [], events)
    assert [(row.command, row.outcome) for row in rows] == [
        ("tense", "refused"),
        ("hey robot", "accepted"),
    ]


def test_each_of_two_equal_commands_gets_its_own_answer(report_config):
    said = [heard("pull more", 1.0, 1.2), heard("pull more", 2.0, 2.2)]
    events = [
        RecordedEvent(1.21, "accepted", "pull more", "first"),
        RecordedEvent(1.3, "motion_started", "pull more", ""),
        RecordedEvent(2.21, "accepted", "pull more", "second"),
        RecordedEvent(2.3, "motion_started", "pull more", ""),
    ]
    rows = rows_of(report_config, said, events)
    assert [(r.message, r.action) for r in rows] == [("first", 1.3), ("second", 2.3)]


def test_a_command_into_a_running_motion_acts_when_it_is_accepted(report_config):
    said = [heard("pull more", 1.0, 1.2), heard("pull more", 1.5, 1.7)]
    events = [
        RecordedEvent(1.21, "accepted", "pull more", ""),
        RecordedEvent(1.3, "motion_started", "pull more", ""),
        RecordedEvent(1.71, "accepted", "pull more", ""),
    ]
    rows = rows_of(report_config, said, events, [Span(1.3, 3.0, "moving")])
    assert rows[1].action == 1.71


def test_a_motion_of_another_command_is_not_the_action(report_config):
    events = [
        RecordedEvent(1.21, "accepted", "tense", ""),
        RecordedEvent(1.5, "accepted", "release", ""),
        RecordedEvent(1.6, "motion_started", "release", ""),
        RecordedEvent(9.0, "motion_started", "tense", ""),
    ]
    rows = rows_of(report_config, [heard("tense", 1.0, 1.2)], events)
    assert rows[0].action is None


def later(value, seconds):
    """The same event, utterance or span, so many seconds later."""
    times = ("time", "speech_start", "speech_end", "decision", "start", "end")
    moved = {name: getattr(value, name) + seconds for name in times if hasattr(value, name)}
    return replace(value, **moved)


def test_commands_among_many_have_the_rows_that_they_have_alone(report_config):
    said = [heard("tense", 1.0, 1.2), heard("pull more", 3.0, 3.2), heard("stop", 5.0, 5.3)]
    events = [
        RecordedEvent(1.21, "accepted", "tense", "reaches"),
        RecordedEvent(1.3, "motion_started", "tense", ""),
        RecordedEvent(3.21, "accepted", "pull more", "further"),
        RecordedEvent(5.3, "stop_received", "stop", "by topic"),
        RecordedEvent(5.31, "stop_received", "stop", "by service"),
        RecordedEvent(6.0, "accepted", "pull more", "by hand", caller="/pedal"),
        RecordedEvent(6.5, "motion_started", "pull more", ""),
        RecordedEvent(7.0, "refused", "tense", "held", caller="/pedal"),
    ]
    states = [Span(1.3, 5.5, "moving"), Span(5.5, 6.5, "halted")]
    alone = rows_of(report_config, said, events, states)
    assert [(r.command, r.outcome, r.action) for r in alone] == [
        ("tense", "accepted", 1.3),
        ("pull more", "accepted", 3.21),
        ("stop", "accepted", 5.3),
        ("pull more", "accepted", 6.5),
        ("tense", "refused", None),
    ]
    rounds = [100.0 * k for k in range(50)]
    many = [[later(v, t) for t in rounds for v in values] for values in (said, events, states)]
    rows = rows_of(report_config, *many)
    assert [(r.command, r.outcome, r.message, r.caller) for r in rows] == [
        (r.command, r.outcome, r.message, r.caller) for _ in rounds for r in alone
    ]
    for found, (time, row) in zip(rows, [(t, r) for t in rounds for r in alone], strict=True):
        assert found.answered == pytest.approx(row.answered + time)
        assert (found.action is None) == (row.action is None)
        assert found.action is None or found.action == pytest.approx(row.action + time)


def test_statistics_agree_with_numpy_and_leave_nan_out():
    x = np.array([3.0, 1.0, math.nan, 2.0])
    found = analysis.statistics(x)
    assert (found.count, found.mean, found.median, found.largest) == (3, 2.0, 2.0, 3.0)
    assert found.rms == pytest.approx(math.sqrt(14 / 3))
    assert math.isnan(analysis.statistics(np.empty(0)).mean)


def test_rcm_error_counts_only_while_moving(data):
    error, moving = data.controller["rcm_error"], data.controller["moving"] > 0
    found = analysis.statistics(analysis.rcm_while_moving(data))
    assert found.count == int(moving.sum()) > 100
    assert found.largest == pytest.approx(float(error[moving].max()))


def test_late_cycles_are_counted():
    loop = Intervals("/t")
    loop.extend(np.array([0.002] * 50 + [0.009] + [0.002] * 49 + [0.0031]))
    timing = analysis.loop_timing(loop, 1.5)
    assert timing.late == 2
    assert timing.period.largest == pytest.approx(0.009)


def test_the_end_of_the_program_is_no_command_of_anybody(report_config):
    events = [
        RecordedEvent(
            5.0, "stop_received", "stop", "the controller is being shut down", "shutdown"
        ),
        RecordedEvent(3.0, "stop_received", "stop", "stopped by /pedal", "stop_topic"),
    ]
    rows = rows_of(report_config, [], events)
    assert [(row.command, row.heard, row.time) for row in rows] == [("stop", None, 3.0)]
