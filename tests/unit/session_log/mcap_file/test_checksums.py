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


def checksums_of(content):
    head = HEAD.pack(CHECKSUM, CHECKSUM_BODY.size)
    found = [m.start() for m in re.finditer(re.escape(head), content)]
    return [(k, *CHECKSUM_BODY.unpack_from(content, k + HEAD.size)) for k in found]


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
    assert len(checksums_of((tmp_path / "s.mcap").read_bytes())) == 5  # the header's, too


@pytest.mark.parametrize("place", ["length", "checksum"])
def test_a_damaged_checksum_costs_its_own_commit(tmp_path, place):
    content = bytearray(write(tmp_path / "s.mcap", 5))
    offset, *_ = checksums_of(content)[3]  # the header's is the first
    content[offset + HEAD.size + (0 if place == "length" else 8)] ^= 1
    (tmp_path / "s.mcap").write_bytes(content)
    reader = SessionReader(tmp_path / "s.mcap")
    assert [m.sequence for m in reader.messages()] == [1, 2, 3, 4, 5, 6, 10, 11, 12, 13, 14, 15]
    assert "3 records left out" in reader.condition.damage[0].what


def test_a_file_without_checksums_is_read_as_it_is(tmp_path):
    content = write(tmp_path / "s.mcap", 5)
    for offset, *_ in reversed(checksums_of(content)):
        content = content[:offset] + content[offset + HEAD.size + CHECKSUM_BODY.size :]
    (tmp_path / "s.mcap").write_bytes(content)
    reader = SessionReader(tmp_path / "s.mcap")
    assert list(reader.messages()) == [message(k) for k in range(15)]
    assert reader.condition.damage == []


def test_a_long_commit_has_its_checksum_on_the_way_and_read_in_little_memory(tmp_path):
    write(tmp_path / "s.mcap", 1, per_commit=400, size=100_000)  # 40 MB at once
    tracemalloc.start()
    count = sum(1 for _ in SessionReader(tmp_path / "s.mcap").messages())
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert count == 400
    assert most < 4 * CHECKSUM_WITHIN + 4_000_000


def test_without_checksums_too_little_is_held_back(tmp_path):
    content = write(tmp_path / "s.mcap", 1, per_commit=400, size=100_000)
    for offset, *_ in reversed(checksums_of(content)):
        content = content[:offset] + content[offset + HEAD.size + CHECKSUM_BODY.size :]
    (tmp_path / "s.mcap").write_bytes(content)
    tracemalloc.start()
    count = sum(1 for _ in SessionReader(tmp_path / "s.mcap").messages())
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert count == 400
    assert most < 2 * checksums.MOST_HELD + 6_000_000
