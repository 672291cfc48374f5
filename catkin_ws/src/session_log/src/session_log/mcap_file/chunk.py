# SPDX-License-Identifier: BSD-3-Clause
"""Opens the chunks of a recording: many records, compressed together, under one checksum."""

from __future__ import annotations

import struct
from io import BytesIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Chunk
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream
from zstandard import ZstdError

from session_log.mcap_file.records import HEAD, LONGEST, SHORTEST, McapRecord

UNREADABLE = (  # what reading damaged records raises
    McapError,
    CRCValidationError,
    ZstdError,
    ValueError,
    struct.error,
    EOFError,
    RuntimeError,
    MemoryError,
)


def records_of(chunk: McapRecord) -> list[tuple[int, bytes]]:
    """Opcode and body of each record in a chunk.

    Raises:
        One of UNREADABLE: The chunk is damaged.
    """
    outer = Chunk.read(ReadDataStream(BytesIO(chunk.body)))
    if outer.uncompressed_size > LONGEST:
        raise ValueError(f"{outer.uncompressed_size} B in one chunk")
    stream, size = get_chunk_data_stream(outer, validate_crc=True)
    content = stream.read(size)
    found, position = [], 0
    while position < size:
        opcode, length = HEAD.unpack_from(content, position)
        begin = position + HEAD.size
        position = begin + length
        if position > size or length < SHORTEST.get(opcode, 0):
            raise ValueError("a record of a length that cannot be")
        found.append((opcode, content[begin:position]))
    return found
