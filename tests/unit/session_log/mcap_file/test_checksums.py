# SPDX-License-Identifier: BSD-3-Clause
"""Checksums of recordings without chunks: what they confirm, what they cost, and files of none."""

import re
import tracemalloc

import pytest
from mcap.reader import make_reader
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader

from session_log.mcap_file import checksums
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.records import CHECKSUM, CHECKSUM_BODY, HEAD
from session_log.types import Message, MessageSource
from tests.unit.session_log.support.unchunked import CHECKSUM_WITHIN, UnchunkedWriter

NOW = 1_795_200_000_000_000_000
SOURCE = MessageSource("/t", "std_msgs/String", "992c", "string data", "/p")


def message(k, size=100):
    return Message(SOURCE, bytes([k % 251]) * size, NOW + k, k + 1)


def write(path, commits, per_commit=3, size=100):
    writer = UnchunkedWriter(path)
    for k in range(commits * per_commit):
        writer.add(message(k, size))
        if k % per_commit == per_commit - 1:
            writer.commit()
    writer.abandon()
    return path.read_bytes()


RECORD = re.compile(
    re.escape(HEAD.pack(CHECKSUM, CHECKSUM_BODY.size)) + b".{%d}" % CHECKSUM_BODY.size, re.DOTALL
)


def without_checksums(path):
    path.write_bytes(RECORD.sub(b"", path.read_bytes()))


def read_with_peak(path):
    """How many messages are read, and the memory that this takes at most [B]."""
    tracemalloc.start()
    count = sum(1 for _ in SessionReader(path).messages())
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return count, most


def test_the_public_reader_skips_checksums_and_its_checksum_includes_them(tmp_path):
    with UnchunkedWriter(tmp_path / "s.mcap") as writer:
        for k in range(4):
            writer.add(message(k))
            writer.commit()
    with (tmp_path / "s.mcap").open("rb") as file:
        assert len(list(make_reader(file, validate_crcs=True).iter_messages())) == 4
        file.seek(0)
        records = list(StreamReader(file, validate_crcs=True).records)
    assert sum(isinstance(r, McapMessage) for r in records) == 4
    assert len(RECORD.findall((tmp_path / "s.mcap").read_bytes())) == 5  # the header's, too


@pytest.mark.parametrize("place", ["length", "checksum"])
def test_a_damaged_checksum_costs_its_own_commit(tmp_path, place):
    content = bytearray(write(tmp_path / "s.mcap", 5))
    *_, third, _, _ = RECORD.finditer(content)  # of five commits
    content[third.start() + HEAD.size + (0 if place == "length" else 8)] ^= 1
    (tmp_path / "s.mcap").write_bytes(content)
    reader = SessionReader(tmp_path / "s.mcap")
    assert [m.sequence for m in reader.messages()] == [1, 2, 3, 4, 5, 6, 10, 11, 12, 13, 14, 15]
    assert "3 records left out" in reader.condition.damage[0].what


def test_a_file_without_checksums_is_read_as_it_is(tmp_path):
    write(tmp_path / "s.mcap", 5)
    without_checksums(tmp_path / "s.mcap")
    reader = SessionReader(tmp_path / "s.mcap")
    assert list(reader.messages()) == [message(k) for k in range(15)]
    assert reader.condition.damage == []


def test_a_long_commit_has_its_checksum_on_the_way_and_read_in_little_memory(tmp_path):
    write(tmp_path / "s.mcap", 1, per_commit=400, size=100_000)  # 40 MB at once
    count, most = read_with_peak(tmp_path / "s.mcap")
    assert count == 400
    assert most < 4 * CHECKSUM_WITHIN + 4_000_000


def test_without_checksums_too_little_is_held_back(tmp_path):
    write(tmp_path / "s.mcap", 1, per_commit=400, size=100_000)
    without_checksums(tmp_path / "s.mcap")
    count, most = read_with_peak(tmp_path / "s.mcap")
    assert count == 400
    assert most < 2 * checksums.MOST_HELD + 6_000_000
