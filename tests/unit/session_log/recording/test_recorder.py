# SPDX-License-Identifier: BSD-3-Clause
"""The recorder loses no message below its limits, and counts and names what it does lose."""

import threading
import time
from dataclasses import replace
from itertools import count

import pytest

from session_log.errors import RecordingFailed
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
from session_log.mcap_file.writer import SessionWriter
from session_log.recording import recorder as recorder_module
from session_log.recording.recorder import MANY_PUBLISHERS, MOST_PUBLISHERS
from support.message_classes import class_of, serialise, source_of
from support.waiting import wait_until
from tests.unit.session_log.support.recorder_inputs import full, text


def test_many_threads_lose_nothing(tmp_path, recorder):
    tallies = [recorder.register(text(f"/t{i}")) for i in range(8)]
    recorder.start()

    def publish(tally):
        for k in range(500):
            assert recorder.offer(tally, b"%d" % k)

    threads = [threading.Thread(target=publish, args=(tally,)) for tally in tallies]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert recorder.close() == ""
    result = read_summary(SessionReader(tmp_path / "s.mcap"))
    assert {t.messages for t in result.topics.values()} == {500}
    assert (result.messages, result.missing, result.condition.is_closed) == (4000, 0, True)


def test_what_is_said_to_be_written_is_in_the_file(tmp_path, recorder):
    tally = recorder.register(text())
    recorder.start()
    for _ in range(10):
        recorder.offer(tally, b"x")
    received = time.time_ns()
    wait_until(lambda: recorder.status().written_until > received)
    assert sum(1 for _ in SessionReader(tmp_path / "s.mcap").messages()) == 10
    recorder.close()


def test_messages_are_dropped_only_above_the_limit_and_counted(tmp_path, make_recorder):
    def never():
        raise RecordingFailed(tmp_path, full())

    recorder = make_recorder(never, queue_messages=100)
    tally = recorder.register(text())
    taken = [recorder.offer(tally, b"x") for _ in range(130)]
    assert taken == [True] * 100 + [False] * 30
    status = recorder.status()
    assert (status.received, status.dropped, status.waiting) == (130, 30, 100)


def test_a_limit_of_bytes_holds_too(make_recorder):
    recorder = make_recorder(pytest.fail, queue_size=1_000_000)
    tally = recorder.register(text())
    assert recorder.offer(tally, bytes(900_000))
    assert not recorder.offer(tally, bytes(200_000))
    assert recorder.offer(tally, bytes(50_000))


def test_what_was_written_makes_room_for_more(make_recorder):
    recorder = make_recorder(queue_size=1_000_000)
    tally = recorder.register(text())
    recorder.start()
    for k in range(5):
        assert recorder.offer(tally, bytes(900_000))
        wait_until(lambda expected=k + 1: recorder.status().written == expected)
    recorder.close()


def test_the_acknowledged_time_is_never_ahead_of_the_clock(tmp_path, make_recorder):
    times = count(1)
    recorder = make_recorder(lambda: SessionWriter(tmp_path / "s.mcap"), times.__next__)
    recorder.start()
    wait_until(lambda: recorder.status().written_until > 0)
    for _ in range(50):
        assert recorder.status().written_until < next(times)
    recorder.close()


def test_a_clock_that_is_set_back_does_not_end_the_syncs(tmp_path, make_recorder, recorder_config):
    """They bound what a power failure takes."""
    hour, clock, steady, syncs = 3600 * 10**9, [1_795_200_000 * 10**9], [0.0], []

    def open_writer():
        writer = SessionWriter(tmp_path / "s.mcap")
        writer.sync = lambda: syncs.append(steady[0])
        return writer

    recorder = make_recorder(open_writer, lambda: clock[0], lambda: steady[0])
    recorder.start()
    wait_until(lambda: len(syncs) == 1)
    clock[0] -= hour
    steady[0] += recorder_config.sync_period
    wait_until(lambda: len(syncs) == 2)
    recorder.close()


def test_an_unexpected_error_is_kept_in_sight(make_recorder):
    def broken():
        raise KeyError("a bug")

    recorder = make_recorder(broken)
    recorder.start()
    wait_until(lambda: "KeyError" in recorder.status().error)
    assert not recorder.status().is_recording
    assert "a bug" in recorder.close()


def test_gaps_in_the_publishers_own_count_are_reported_and_recorded(tmp_path, recorder):
    tally = recorder.register(source_of("/rst_control/event", "rst_control/Event", "/controller"))
    recorder.start()
    for sequence in (5, 6, 9, 10, 12):
        message = class_of("rst_control/Event")()
        message.header.seq = sequence
        recorder.offer(tally, serialise(message))
    assert recorder.status().missed == 3
    recorder.close()
    losses = read_summary(SessionReader(tmp_path / "s.mcap")).losses
    assert losses == {"/rst_control/event from /controller": "0 dropped, 3 missed"}


def test_what_two_types_of_one_publisher_lost_is_summed(tmp_path, make_recorder):
    recorder = make_recorder(queue_messages=100)
    tallies = [recorder.register(replace(text(), md5sum=md5sum)) for md5sum in ("a", "b")]
    for _ in range(70):
        for tally in tallies:
            recorder.offer(tally, b"x")
    recorder.start()
    recorder.close()
    losses = read_summary(SessionReader(tmp_path / "s.mcap")).losses
    assert losses == {"/t from /p": "40 dropped, 0 missed"}


def test_the_latched_message_from_before_the_connection_opens_no_gap(make_recorder):
    recorder = make_recorder(pytest.fail)
    source = source_of("/mode", "voice_assist/Mode", "/voice", is_latched=True)
    tally = recorder.register(source)
    for sequence in (1, 7, 8, 10):
        message = class_of("voice_assist/Mode")()
        message.header.seq = sequence
        recorder.offer(tally, serialise(message))
    assert recorder.status().missed == 1


def test_metadata_may_come_at_any_time_and_the_last_of_a_name_counts(tmp_path, recorder):
    recorder.start()
    recorder.add_metadata("parameters", {"gain": "1"})
    recorder.add_metadata("parameters", {"gain": "2"})
    recorder.close()
    condition = read_summary(SessionReader(tmp_path / "s.mcap")).condition
    assert condition.latest("parameters") == {"gain": "2"}
    assert [name for name, _ in condition.metadata] == ["parameters", "parameters"]


def test_publishers_without_end_share_a_channel_and_lose_nothing(tmp_path, recorder):
    """Each `rostopic pub` of a script is a new node; a file has 65,535 channels."""
    recorder.start()
    count = 66_000
    kind = "rst_control/Event"
    data = serialise(class_of(kind)())
    one = source_of("/rst_control/event", kind)
    for k in range(count):
        tally = recorder.register(replace(one, publisher=f"/rostopic_{k}"))
        if k % 200 == 0 or k >= count - 10:
            assert recorder.offer(tally, data)
    assert len(recorder.tallies()) == MOST_PUBLISHERS + 1
    assert recorder.close() == ""
    result = read_summary(SessionReader(tmp_path / "s.mcap"))
    assert (result.messages, result.missing) == (count // 200 + 10, 0)
    assert MANY_PUBLISHERS in result.topics["/rst_control/event"].publishers
    assert recorder.status().missed == 0  # each counts its header for itself


def test_topics_that_no_file_can_hold_are_named_and_the_others_recorded(
    tmp_path, recorder, monkeypatch
):
    monkeypatch.setattr(recorder_module, "MOST_CHANNELS", 3)
    recorder.start()
    taken = [recorder.offer(recorder.register(text(f"/t{k}")), b"x") for k in range(5)]
    assert taken == [True, True, True, False, False]
    assert recorder.status().error == "more than 3 topics: the others are not recorded"
    recorder.close()
    reader = SessionReader(tmp_path / "s.mcap")
    assert read_summary(reader).messages == 3
    assert reader.condition.latest("losses")["/t4 from /p"] == "1 dropped, 0 missed"
