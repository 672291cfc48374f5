# SPDX-License-Identifier: BSD-3-Clause
import struct

import numpy as np
import pytest

from session_log.export.arrays import read_columns
from session_log.mcap_file.reader import SessionReader
from session_log.types import Message, MessageSource
from support.story import recording_of

NOW = 1_795_200_000_000_000_000  # [ns]


@pytest.fixture(scope="module")
def states(story):
    return read_columns(SessionReader(story[0]), "/rst_control/state")


def test_every_message_is_a_row_in_the_order_of_the_file(story, states):
    times = [m.log_time for m in story[1] if m.source.topic == "/rst_control/state"]
    assert states["log_time"].astype(np.int64).tolist() == times
    assert {len(column) for column in states.values()} == {len(times)}


def test_columns_have_the_kinds_of_their_fields(states):
    assert states["header.stamp"].dtype == states["log_time"].dtype == np.dtype("datetime64[ns]")
    assert states["tension"].dtype == np.float64 and states["halted"].dtype == bool
    assert set(states["state"]) >= {"standby", "active", "moving"}


def test_lists_and_texts_are_objects(story):
    columns = read_columns(SessionReader(story[0]), "/voice_assist/utterance")
    assert columns["phrases"].shape == columns["wer"].shape == columns["command"].shape
    assert "stop" in columns["phrases"][0] and "tense" in set(columns["command"])


def test_durations_are_none_of_a_date(tmp_path):
    source = MessageSource("/d", "test_msgs/T", "", "duration d")
    payload = struct.pack("<ii", -1, 500_000_000)
    reader = recording_of(tmp_path / "s.mcap", [Message(source, payload, NOW, 1)])
    (found,) = read_columns(reader, "/d")["d"]
    assert found == np.timedelta64(-500, "ms")


def test_a_topic_of_which_nothing_was_recorded_has_no_columns(story):
    assert read_columns(SessionReader(story[0]), "/nothing") == {}
