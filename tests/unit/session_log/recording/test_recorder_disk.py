# SPDX-License-Identifier: BSD-3-Clause
"""The recorder on a disk that is full, slow, hangs or cannot be written."""

import os
import threading
import time

import pytest

from session_log.config import RecorderConfig
from session_log.errors import RecordingFailed
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
from session_log.mcap_file.writer import SessionWriter
from support.waiting import PATIENCE, wait_until
from tests.unit.session_log.support.recorder_inputs import full, text
from typed_config import ConfigError, load_config


def on_disk(folder, write):
    """A writer whose bytes go through this function."""
    writer = SessionWriter(folder / "s.mcap")
    writer._stream._write = write
    return writer


def test_a_folder_that_cannot_be_written_is_said_and_tried_again(tmp_path, make_recorder):
    attempts, is_seen = [], threading.Event()

    def open_writer():
        attempts.append(1)
        if len(attempts) < 4 or not is_seen.is_set():
            raise RecordingFailed(tmp_path / "s.mcap", PermissionError(13, "Permission denied"))
        return SessionWriter(tmp_path / "s.mcap")

    recorder = make_recorder(open_writer, retry_period=0.05)
    tally = recorder.register(text())
    recorder.start()
    recorder.offer(tally, b"early")
    wait_until(lambda: "Permission denied" in recorder.status().error)
    assert not recorder.status().is_recording
    is_seen.set()
    wait_until(lambda: recorder.status().is_recording)
    assert recorder.close() == ""
    (message,) = SessionReader(tmp_path / "s.mcap").messages()
    assert message.data == b"early"


def test_a_disk_that_fills_and_empties_again_costs_nothing(tmp_path, make_recorder):
    room = [10_000]

    def write(fd, data):
        if room[0] < len(data):
            raise full()
        room[0] -= len(data)
        return os.write(fd, data)

    recorder = make_recorder(lambda: on_disk(tmp_path, write), retry_period=0.05)
    tally = recorder.register(text())
    recorder.start()
    for _ in range(300):
        recorder.offer(tally, os.urandom(100))
    wait_until(lambda: "No space left" in recorder.status().error)
    room[0] = 10**9
    wait_until(lambda: recorder.status().is_recording)
    assert recorder.close() == ""
    result = read_summary(SessionReader(tmp_path / "s.mcap"))
    assert (result.messages, result.missing, result.condition.damage) == (300, 0, [])
    assert recorder.status().written == 300


@pytest.mark.parametrize("sync_period", [0.0, 600.0])
def test_a_file_that_is_deleted_is_lost_however_seldom_the_disk_is_waited_for(
    tmp_path, make_recorder, sync_period
):
    recorder = make_recorder(sync_period=sync_period)
    recorder.start()
    wait_until(lambda: recorder.status().is_recording)
    (tmp_path / "s.mcap").unlink()
    wait_until(lambda: "deleted while" in recorder.status().error)
    assert not recorder.status().is_recording
    assert "deleted while" in recorder.close()


def test_memory_stays_bounded_while_the_disk_is_full(tmp_path, make_recorder):
    def write(fd, data):
        raise full()

    changes = {"queue_messages": 100, "retry_period": 0.05}
    recorder = make_recorder(lambda: on_disk(tmp_path, write), **changes)
    tally = recorder.register(text())
    recorder.offer(tally, b"x")
    recorder.start()
    wait_until(lambda: recorder.status().error)
    held = recorder._writer._stream.tell()
    for _ in range(3):
        for _ in range(100):
            recorder.offer(tally, os.urandom(100))
        time.sleep(0.15)  # several attempts
    status = recorder.status()
    assert (status.waiting, status.dropped) == (100, 200)
    assert recorder._writer._stream.tell() == held
    recorder.close()


def test_closing_while_the_disk_is_full_says_how_much_was_lost(tmp_path, make_recorder):
    def never():
        raise RecordingFailed(tmp_path / "s.mcap", full())

    recorder = make_recorder(never)
    tally = recorder.register(text())
    recorder.start()
    for _ in range(3):
        recorder.offer(tally, b"x")
    assert recorder.close().endswith("No space left on device; 3 messages were not written")


def test_what_waits_for_a_full_disk_at_the_end_is_counted(tmp_path, make_recorder):
    """As well what a failed commit has taken from the queue as what has come since."""
    is_full = threading.Event()

    def write(fd, data):
        if is_full.is_set():
            raise full()
        return os.write(fd, data)

    recorder = make_recorder(lambda: on_disk(tmp_path, write), retry_period=60.0)
    tally = recorder.register(text())
    recorder.start()
    wait_until(lambda: recorder.status().is_recording)
    is_full.set()
    recorder.offer(tally, b"x")
    wait_until(lambda: recorder.status().error)
    recorder.offer(tally, b"x")
    assert recorder.close().endswith("No space left on device; 2 messages were not written")
    assert recorder.status().written == 0


class Blocking:
    """A disk whose writes take as long as the test likes."""

    def __init__(self):
        self.is_free = threading.Event()
        self.is_free.set()

    def write(self, fd, data):
        assert self.is_free.wait(PATIENCE)
        return os.write(fd, data)


def test_a_disk_that_hangs_without_an_error_is_an_error_until_it_goes_on(
    tmp_path, make_recorder, recorder_config
):
    disk, now = Blocking(), [0.0]
    clocks = time.time_ns, lambda: now[0]
    recorder = make_recorder(lambda: on_disk(tmp_path, disk.write), *clocks)
    tally = recorder.register(text())
    recorder.start()
    wait_until(lambda: recorder.status().is_recording)
    disk.is_free.clear()
    recorder.offer(tally, b"x")
    wait_until(lambda: recorder.status().waiting == 0)  # the writer has taken it, and hangs
    assert recorder.status().is_recording
    now[0] += recorder_config.stall_time + 0.1
    status = recorder.status()
    assert status.error == "the disk has taken nothing for more than 3 s"
    assert not status.is_recording and status.written == 0
    disk.is_free.set()
    wait_until(lambda: recorder.status().is_recording)
    assert recorder.close() == "" and recorder.status().written == 1


def test_a_drop_counts_as_loss_for_a_while_and_stays_counted(make_recorder, recorder_config):
    now = [0.0]
    recorder = make_recorder(pytest.fail, time.time_ns, lambda: now[0], queue_messages=100)
    tally = recorder.register(text())
    for _ in range(100):
        recorder.offer(tally, b"x")
    assert recorder.status().error == ""
    recorder.offer(tally, b"one too many")
    now[0] = recorder_config.stall_time
    assert recorder.status().error == "messages are being dropped: the disk is too slow"
    now[0] += 0.1
    assert (recorder.status().error, recorder.status().dropped) == ("", 1)


def test_either_bound_of_the_queue_holds_a_session_for_twenty_minutes(recorder_config):
    assert recorder_config.queue_messages / 1600 >= 20 * 60  # messages/s
    assert recorder_config.queue_size / 400_000 >= 20 * 60  # [B/s]


@pytest.mark.parametrize("flush_period", [0.5, 0.3, 0.2])
def test_a_stall_time_that_is_over_before_two_writes_is_refused(recorder_settings, flush_period):
    settings = {**recorder_settings, "flush_period": flush_period, "stall_time": 0.3}
    words = rf"stall_time is 0\.3, allowed: at least twice flush_period, {2 * flush_period:g} s"
    with pytest.raises(ConfigError, match=words):
        load_config(RecorderConfig, settings, "recorder.yaml")


def test_a_stall_time_of_two_writes_is_allowed(recorder_settings):
    settings = {**recorder_settings, "flush_period": 0.15, "stall_time": 0.3}
    assert load_config(RecorderConfig, settings, "recorder.yaml").stall_time == 0.3
