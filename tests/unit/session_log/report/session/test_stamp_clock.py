# SPDX-License-Identifier: BSD-3-Clause
"""Times in a session whose stamps are of another clock than the recorder's."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from session_log.report.session.analysis import command_rows
from session_log.report.session.extract import extract
from session_log.report.session.shaft import rcm_from_joints
from session_log.report.session.stamp_clock import APART, LONG, MANY, StampClock
from session_log.report.session.summary import summarise
from support.message_classes import source_of
from support.story import START, Story, recording_of

SECOND = 1_000_000_000  # [ns]
CLOCKS = {"simulated": START, "an hour behind": 3600 * SECOND, "a minute ahead": -60 * SECOND}
SOURCE = source_of("/joint_states", "sensor_msgs/JointState")


class StoryOfAnotherClock(Story):
    """Its stamps are this much behind the recorder's clock [ns]."""

    def __init__(self, lag, **options):
        super().__init__(**options)
        self.lag = lag

    def set_time(self, stamp, seconds):
        stamp.secs, stamp.nsecs = divmod(self.start - self.lag + int(seconds * SECOND), SECOND)


class StoryOfAVoiceHostSetBack(Story):
    """The clock of the voice node's host is set back in the middle, the others' is not."""

    SINCE, LAG = 15.0, 10 * SECOND

    def __init__(self, is_set_back):
        super().__init__(rate=20)
        self.is_set_back, self.is_voice = is_set_back, False

    def say(self, time, topic, datatype, **fields):
        self.is_voice = topic.startswith("/voice_assist/")
        super().say(time, topic, datatype, **fields)

    def set_time(self, stamp, seconds):
        lag = self.LAG if self.is_set_back and self.is_voice and seconds >= self.SINCE else 0
        stamp.secs, stamp.nsecs = divmod(self.start - lag + int(seconds * SECOND), SECOND)


@pytest.fixture(scope="module")
def data_of(report_config, tmp_path_factory):
    config = replace(report_config, utterance_sound=False)

    @cache
    def read(lag):
        story = StoryOfAnotherClock(lag, duration=7.0, rate=20)
        path = tmp_path_factory.mktemp("clock") / "session.mcap"
        return extract(recording_of(path, list(story.build())), config)

    return read


@pytest.fixture(scope="module")
def by_one_clock(data_of):
    return data_of(0)


def times_of(data):
    """Times in each table, by its name [s]."""
    heard = [(h.speech_start, h.speech_end, h.decision) for h in data.heard]
    spans = {"modes": data.modes, "states": data.states, "phases": data.phases}
    return {
        "utterances": np.ravel(heard),
        "events": [event.time for event in data.events],
        "pictures": [picture.time for picture in data.pictures],
        "joints": data.joints["time"],
        "tension": data.tension["time"],
        "controller": data.controller["time"],
        "sound": data.sound["time"],
        **{name: np.ravel([(s.start, s.end) for s in found]) for name, found in spans.items()},
    }


@pytest.mark.parametrize("lag", CLOCKS.values(), ids=CLOCKS)
def test_every_table_has_the_times_of_the_recorders_clock(by_one_clock, data_of, lag):
    expected, found = times_of(by_one_clock), times_of(data_of(lag))
    for name, times in expected.items():
        assert len(times) and found[name] == pytest.approx(times, abs=0.05), name


@pytest.mark.parametrize("lag", CLOCKS.values(), ids=CLOCKS)
def test_how_long_somebody_spoke_and_a_cycle_took_is_as_it_was_stamped(by_one_clock, data_of, lag):
    found = data_of(lag)
    for one, other in zip(by_one_clock.heard, found.heard, strict=True):
        length = one.speech_end - one.speech_start
        assert other.speech_end - other.speech_start == pytest.approx(length, abs=1e-6)
    for one, other in zip(by_one_clock.loops, found.loops, strict=True):
        assert list(other.length)[1:] == pytest.approx(list(one.length)[1:], abs=1e-6)


def test_each_topic_of_another_clock_is_known_with_the_distance(by_one_clock, data_of):
    assert by_one_clock.clock_lags == {}
    lags = data_of(3600 * SECOND).clock_lags
    assert {"/joint_states", "/rst_control/state", "/voice_assist/utterance"} <= set(lags)
    assert list(lags.values()) == pytest.approx([3600.0] * len(lags), abs=0.1)


def in_log_time(clock, *pairs):
    stamps, arrivals = (np.array(side, np.int64) for side in zip(*pairs, strict=True))
    return clock.in_log_time(stamps, arrivals).tolist()


def test_one_message_that_was_late_makes_no_other_clock():
    lags = {}
    clock = StampClock(SOURCE, lags)
    pairs = [(100, 101), (102, 102 + int(2 * APART) * SECOND), (104, 105)]
    assert in_log_time(clock, *pairs) == [100, 102, 104] and lags == {}


@pytest.mark.parametrize(("lag", "offset"), [(0.05, None), (0.8, 0.8), (-0.3, -0.3)])
def test_a_clock_that_is_a_little_off_is_known_by_the_smallest_lag(lag, offset):
    clock = StampClock(SOURCE, {})
    for k in range(MANY):  # one of which came 2 s late
        arrival = START + k * SECOND + int(lag * 1e9) + (k == 0) * 2 * SECOND
        assert in_log_time(clock, (START + k * SECOND, arrival)) == [START + k * SECOND]
        assert k == MANY - 1 or clock.offset is None
    assert clock.offset == (offset and ("/joint_states", pytest.approx(offset)))


def test_a_stamp_that_was_not_set_decides_nothing():
    lags = {}
    clock = StampClock(SOURCE, lags)
    assert in_log_time(clock, (0, START)) == [START] and lags == {}
    assert in_log_time(clock, (START + 5, START + 7)) == [START + 5]


def test_a_latched_message_of_long_ago_has_the_time_of_its_arrival_and_no_warning():
    lags = {}
    clock = StampClock(replace(SOURCE, is_latched=True), lags)
    assert in_log_time(clock, (START - 600 * SECOND, START)) == [START] and lags == {}


@pytest.mark.parametrize("together", [1, 100])  # as slow topics are read, and fast ones
@pytest.mark.parametrize("lag", [10.0, -10.0])
def test_from_where_a_clock_was_set_times_are_those_of_arrival(together, lag):
    lags = {}
    clock = StampClock(SOURCE, lags)
    arrivals = START + np.arange(100) * SECOND
    stamps = arrivals - np.where(np.arange(100) < 50, 0, int(lag * SECOND))
    times = [
        clock.in_log_time(stamps[k : k + together], arrivals[k : k + together])
        for k in range(0, 100, together)
    ]
    assert np.concatenate(times).tolist() == arrivals.tolist()
    assert lags == {"/joint_states": pytest.approx(lag)} and clock.offset is None


def test_after_a_clock_was_set_right_its_stamps_count_again():
    clock = StampClock(SOURCE, {})
    assert in_log_time(clock, (START, START + 10 * SECOND)) == [START + 10 * SECOND]
    assert in_log_time(clock, (START + 20 * SECOND, START + 21 * SECOND)) == [START + 20 * SECOND]


def test_of_several_distances_the_largest_is_known():
    lags = {}
    clock = StampClock(SOURCE, lags)
    for lag in (10, -60, 20):
        in_log_time(clock, (START, START + lag * SECOND))
    assert lags == {"/joint_states": pytest.approx(-60.0)}


@pytest.mark.parametrize("together", [330, 1000])  # as a topic is read; 330: in a pause
@pytest.mark.parametrize("rate", [10, 50, 1000])  # [Hz]
@pytest.mark.parametrize("pause", [3.5, 4.0, 8.0])  # [s]
def test_messages_that_were_held_up_for_a_while_are_of_the_same_clock(rate, pause, together):
    lags = {}
    clock = StampClock(SOURCE, lags)
    stamps = START + np.arange(30 * rate) * SECOND // rate
    begin, end = START + 10 * SECOND, START + int((10.0 + pause) * SECOND)
    is_held = (stamps >= begin) & (stamps < end)
    sent_on = end + np.cumsum(is_held) * SECOND // 10_000  # one after the other
    arrivals = np.where(is_held, sent_on, np.maximum(stamps, (stamps >= end) * sent_on[-1]))
    for k in range(0, len(stamps), together):
        part = slice(k, k + together)
        assert clock.in_log_time(stamps[part], arrivals[part]).tolist() == stamps[part].tolist()
    assert lags == {} and clock.offset is None


def test_an_event_that_was_held_up_keeps_its_stamp():
    lags = {}
    clock = StampClock(SOURCE, lags)
    for sent, came in ((0, 0), (20, 20), (21, 25), (24, 25), (40, 40)):
        sent, came = (START + time * SECOND for time in (sent, came))
        assert in_log_time(clock, (sent, came)) == [sent]
    assert lags == {}


def test_a_clock_that_was_set_back_while_messages_were_held_up_is_another():
    lags = {}
    clock = StampClock(SOURCE, lags)
    true = START + np.arange(2000) * SECOND // 50
    stamps = true - np.where(true < START + 12 * SECOND, 0, 10 * SECOND)
    is_held = (true >= START + 10 * SECOND) & (true < START + 15 * SECOND)
    arrivals = np.where(is_held, START + 15 * SECOND, true)
    times = clock.in_log_time(stamps, arrivals)
    later = arrivals > START + int((15.0 + APART) * SECOND)
    assert times[later].tolist() == arrivals[later].tolist()
    assert lags == {"/joint_states": pytest.approx(10.0)}


@pytest.mark.parametrize("together", [1, 500])
@pytest.mark.parametrize("lag", [0.8, -0.3])
def test_a_clock_that_was_set_a_little_off_is_known(together, lag):
    clock = StampClock(SOURCE, {})
    stamps = START + np.arange(1000) * SECOND // 10
    arrivals = stamps + np.where(np.arange(1000) < 400, 0, int(lag * SECOND))
    for k in range(0, 1000, together):
        part = slice(k, k + together)
        assert clock.in_log_time(stamps[part], arrivals[part]).tolist() == stamps[part].tolist()
    assert clock.offset == ("/joint_states", pytest.approx(lag))


def test_a_pause_of_the_recorder_is_no_clock_that_is_a_little_off():
    clock = StampClock(SOURCE, {})
    stamps = START + np.arange(20_000) * SECOND // 500
    for begin in (9.9, 20.0, 30.0):  # [s] messages of two seconds come together
        end = START + int((begin + 2.0) * SECOND)
        is_held = (stamps >= START + int(begin * SECOND)) & (stamps < end)
        arrivals = np.where(is_held, end, stamps)
        for k in range(0, len(stamps), 1000):
            clock.in_log_time(stamps[k : k + 1000], arrivals[k : k + 1000])
    assert clock.offset is None and LONG > 2.0


def test_commands_find_their_answers_after_the_voice_hosts_clock_was_set_back(
    report_config, tmp_path
):
    config = replace(report_config, utterance_sound=False)
    rows, complete = [], []
    for is_set_back in (False, True):
        story = StoryOfAVoiceHostSetBack(is_set_back)
        session = recording_of(tmp_path / f"{is_set_back}.mcap", list(story.build()))
        data = extract(session, config)
        rows.append(command_rows(data, config))
        rcm = rcm_from_joints(data, config)
        complete.append(summarise("s", data, rows[-1], rcm, config).is_complete)
    outcomes, found = ([(row.command, row.outcome) for row in side] for side in rows)
    assert found == outcomes and "no answer" not in dict(outcomes).values()
    assert complete == [True, False]
    expected = {f"/voice_assist/{name}": 10.0 for name in ("audio", "mode", "utterance")}
    assert data.clock_lags == pytest.approx(expected, abs=0.1)


def noted(stamps, arrivals, together=1000):
    """Times by a clock that reads so many messages at once, the lags that it noted, and itself."""
    lags = {}
    clock = StampClock(SOURCE, lags)
    parts = [slice(k, k + together) for k in range(0, len(stamps), together)]
    times = [clock.in_log_time(stamps[part], arrivals[part]) for part in parts]
    return np.concatenate(times), lags, clock


@pytest.mark.parametrize("together", [1, 1000])
@pytest.mark.parametrize("place", [0, 10, 3000, 5990, 5999])
def test_one_stamp_that_is_ahead_makes_no_clock_that_is_a_little_off(place, together):
    arrivals = START + np.arange(6000) * SECOND // 100
    stamps = arrivals - 2_000_000
    stamps[place] += SECOND // 5
    assert noted(stamps, arrivals, together)[2].offset is None


def test_one_stamp_that_is_ahead_hides_no_clock_that_is_behind():
    arrivals = START + np.arange(1000) * SECOND // 100
    stamps = arrivals - int(0.8 * SECOND)
    stamps[::500] += SECOND
    assert noted(stamps, arrivals)[2].offset == ("/joint_states", pytest.approx(0.8))


@pytest.mark.parametrize("count", [1, MANY - 1])
@pytest.mark.parametrize("place", [0, 1, 500, 998, 999])  # of the last one, in the second batch
def test_a_few_late_messages_make_no_other_clock_wherever_a_batch_ends(place, count):
    arrivals = START + np.arange(4000) * SECOND // 100
    late = np.arange(1001 + place - count, 1001 + place)
    stamps = arrivals - 2_000_000
    stamps[late] -= 4 * SECOND
    times, lags, clock = noted(stamps, arrivals)
    assert lags == {} and clock.offset is None
    is_own = times == stamps
    assert np.delete(is_own, late).all() and is_own[late[late >= 1000]].all() == (place < 999)
    assert (times[~is_own] == arrivals[~is_own]).all()  # at the end of a batch nobody knows


@pytest.mark.parametrize("count", [1, MANY - 1])
def test_a_few_late_messages_at_the_begin_of_a_recording_make_no_other_clock(count):
    arrivals = START + np.arange(1000) * SECOND // 100
    stamps = arrivals - np.where(np.arange(1000) < count, 4 * SECOND, 0)
    times, lags, _ = noted(stamps, arrivals)
    assert lags == {} and times.tolist() == arrivals.tolist()


@pytest.mark.parametrize("begin", [981, 990, 999, 1000, 1001])
@pytest.mark.parametrize("end", [1015, 1500, 2000, 2001, 2019, 3000])
def test_a_clock_that_was_set_is_another_wherever_a_batch_ends(begin, end):
    arrivals = START + np.arange(3000) * SECOND // 100
    place = np.arange(3000)
    stamps = arrivals - np.where((place >= begin) & (place < end), 3600 * SECOND, 0)
    times, lags, _ = noted(stamps, arrivals)
    is_many = end - begin >= MANY
    assert lags == ({"/joint_states": pytest.approx(3600.0)} if is_many else {})
    assert not is_many or times.tolist() == arrivals.tolist()
