# SPDX-License-Identifier: BSD-3-Clause
import math

import pytest

from session_log.report.session.session_data import RecordedEvent, Span
from session_log.report.session.stops import UNREPORTED, stops
from session_log.report.tables.session_tables import stops_table

TOPIC, SERVICE = "stopped by voice", '"stop" from /voice_assist'
OVER = "tension 2.50 N, allowed 2.40 N"


def test_a_stop_by_a_watchdog_begins_with_its_braking():
    events = [
        RecordedEvent(5.1, "at_rest", "tense", OVER),
        RecordedEvent(5.1, "halted", "tense", OVER),
    ]
    states = [
        Span(1.0, 5.0, "moving"),
        Span(5.0, 5.09, "stopping"),
        Span(5.09, 9.0, "faulted"),
    ]
    (stop,) = stops(events, states)
    assert stop.time == 5.0 and stop.at_rest == pytest.approx(0.1) and stop.is_latched


def test_a_stop_at_rest_moves_nothing_and_latches():
    events = [
        RecordedEvent(2.0, "stop_received", "stop", TOPIC),
        RecordedEvent(2.0, "halted", "", TOPIC),
    ]
    (stop,) = stops(events, [])
    assert stop.is_latched and math.isnan(stop.at_rest)


def test_what_ended_without_a_latch_says_so():
    events = [RecordedEvent(3.0, "at_rest", "tense", "terminated")]
    (stop,) = stops(events, [])
    assert (stop.cause, stop.is_latched) == ("terminated", False)


def test_every_stop_that_was_said_is_a_row():
    events = [
        RecordedEvent(2.0, "stop_received", "stop", TOPIC),
        RecordedEvent(2.0, "halted", "", TOPIC),
        RecordedEvent(4.0, "stop_received", "stop", TOPIC),
    ]
    assert [stop.time for stop in stops(events, [])] == [2.0, 4.0]


@pytest.mark.parametrize("words", [(TOPIC,), (TOPIC, SERVICE), (SERVICE, TOPIC)])
def test_a_stop_that_comes_by_topic_and_by_service_is_one_row(words):
    """With its first cause and its braking time, as one that comes by one way alone."""
    events = [
        RecordedEvent(1.0, "motion_started", "tense", "goes"),
        *(RecordedEvent(2.0 + 2e-3 * k, "stop_received", "stop", w) for k, w in enumerate(words)),
        RecordedEvent(2.1, "at_rest", "tense", TOPIC),
        RecordedEvent(2.1, "halted", "tense", TOPIC),
    ]
    (stop,) = stops(events, [])
    assert (stop.time, stop.cause, stop.command, stop.is_latched) == (2.0, words[0], "tense", True)
    assert stop.at_rest == pytest.approx(0.1)


def test_a_latch_without_any_cause_is_shown_as_such():
    states = [Span(0.0, 4.0, "active"), Span(4.0, 9.0, "faulted")]
    (stop,) = stops([], states)
    assert (stop.time, stop.cause) == (4.0, UNREPORTED)
    table = stops_table([stop])
    assert table.marks == ("bad",) and table.rows[0][1] == UNREPORTED


def test_a_session_without_stops_has_no_rows():
    events = [
        RecordedEvent(1.0, "accepted", "tense", "x"),
        RecordedEvent(2.0, "refused", "tense", "busy"),
    ]
    assert stops(events, [Span(0.0, 9.0, "active")]) == []


def test_a_second_stop_in_the_same_words_is_a_row_with_its_own_braking_time():
    words = "nothing between the jaws"
    events = [RecordedEvent(time, "at_rest", "tense", words) for time in (3.0, 9.0)]
    states = [Span(2.9, 3.0, "stopping"), Span(3.0, 8.8, "active"), Span(8.8, 9.0, "stopping")]
    found = stops(events, states)
    assert [stop.time for stop in found] == [2.9, 8.8]
    assert [stop.at_rest for stop in found] == pytest.approx([0.1, 0.2])


def test_a_latch_belongs_to_the_newer_of_two_stops_in_the_same_words():
    kinds = ((3.0, "at_rest"), (9.0, "at_rest"), (9.0, "halted"))
    found = stops([RecordedEvent(time, kind, "tense", OVER) for time, kind in kinds], [])
    assert [(stop.time, stop.is_latched) for stop in found] == [(3.0, False), (9.0, True)]


@pytest.mark.parametrize("latch", [2.0, 2.002, 2.01])
def test_a_stop_at_rest_by_topic_and_by_service_is_one_row(latch):
    """It latches between the two, or is stamped before both."""
    events = [
        RecordedEvent(latch, "halted", "", TOPIC),
        RecordedEvent(2.001, "stop_received", "stop", TOPIC),
        RecordedEvent(2.01, "stop_received", "stop", '"stop" from /display'),
    ]
    (stop,) = stops(events, [])
    assert (stop.cause, stop.is_latched) == (TOPIC, True) and math.isnan(stop.at_rest)
