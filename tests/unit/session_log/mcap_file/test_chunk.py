# SPDX-License-Identifier: BSD-3-Clause
import struct

import pytest
from mcap.opcode import Opcode

from session_log.mcap_file.chunk import UNREADABLE, content_of
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.records import CHUNK, McapRecord, RecordWalker
from session_log.mcap_file.writer import SessionWriter
from session_log.types import Message, MessageSource

SIZES = [2**63, 2**64 - 1]  # [B]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("field", ["uncompressed", "data"])
def test_a_size_that_cannot_be_is_damage(size, field):
    uncompressed, data = (size, 0) if field == "uncompressed" else (0, size)
    body = struct.pack("<QQQII", 0, 0, uncompressed, 0, 0) + struct.pack("<Q", data) + b"x"
    with pytest.raises(UNREADABLE):
        content_of(McapRecord(0, Opcode.CHUNK, body))


def test_messages_whose_topic_was_named_in_a_damaged_chunk_are_counted_as_lost(tmp_path):
    """A file that was never closed has the names of its topics in the first chunk alone."""
    path = tmp_path / "killed.mcap"
    source = MessageSource("/t", "std_msgs/String", "99" * 16, "string data", "/p")
    writer = SessionWriter(path)
    for sequence in range(1, 5):
        writer.add(Message(source, b"x", 1_795_200_000 * 10**9 + sequence, sequence))
        if sequence % 2 == 0:
            writer.commit()
    writer.abandon()
    with path.open("rb") as file:
        walked = RecordWalker(file, lambda *_: True).walk(8)
        first, _ = [record for record in walked if record.opcode == CHUNK]
    content = bytearray(path.read_bytes())
    content[first.offset + 60] ^= 1
    path.write_bytes(content)
    reader = SessionReader(path)
    assert list(reader.messages()) == []
    words = [damage.what for damage in reader.condition.damage]
    assert words[0] == "damaged chunk"
    assert words[1] == "2 messages of topics whose names are lost"
