# SPDX-License-Identifier: BSD-3-Clause
"""Faults that others met in recordings; `README.md` here lists the tests of all."""

from __future__ import annotations

import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader

from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.writer import SessionWriter
from session_log.types import Message, MessageSource

SOURCE = MessageSource(
    "/t", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data", "/w"
)
BEGIN = 1_795_200_000 * 10**9  # [ns]
COUNT = 50


def message(k):
    text = b"%d" % k
    return Message(SOURCE, len(text).to_bytes(4, "little") + text, BEGIN + k, k)


@pytest.fixture
def unclosed(tmp_path):
    """A recording whose last messages were committed, and that nobody closed."""
    path = tmp_path / "session.mcap"
    writer = SessionWriter(path)
    for k in range(1, COUNT + 1):
        writer.add(message(k))
    writer.commit()
    yield path
    writer.close()


def test_an_unclosed_recording_is_read_where_mcaps_own_reader_refuses_it(unclosed):
    """`make_reader` looks for the end of the file first, which a killed recorder never wrote."""
    with unclosed.open("rb") as file, pytest.raises(McapError):
        list(make_reader(file).iter_messages())
    assert [m.sequence for m in SessionReader(unclosed).messages()] == list(range(1, COUNT + 1))


def test_a_commit_leaves_nothing_in_the_memory_of_the_recorder(tmp_path):
    """With the default writer SIGKILL took all 1,956 messages: they waited in a chunk."""
    path = tmp_path / "session.mcap"
    writer = SessionWriter(path)
    for k in range(1, 4):
        writer.add(message(k))
        writer.commit()
        assert sum(1 for _ in SessionReader(path).messages()) == k
    writer.close()
