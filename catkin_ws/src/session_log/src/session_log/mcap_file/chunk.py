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
    OverflowError,
)


def content_of(chunk: McapRecord) -> bytes:
    """The records of a chunk, as they were compressed.

    Raises:
        One of UNREADABLE: The chunk is damaged.
    """
    outer = Chunk.read(ReadDataStream(BytesIO(chunk.body)))
    if outer.uncompressed_size > LONGEST:
        raise ValueError(f"{outer.uncompressed_size} B in one chunk, allowed: {LONGEST}")
    stream, size = get_chunk_data_stream(outer, validate_crc=True)
    return stream.read(size)


def places_of(content: bytes) -> list[tuple[int, int, int]]:
    """Opcode, begin and end of the body of each record [B].

    Raises:
        ValueError, struct.error: They are none.
    """
    found, position, size = [], 0, len(content)
    unpack = HEAD.unpack_from
    while position < size:
        opcode, length = unpack(content, position)
        begin = position + HEAD.size
        position = begin + length
        if position > size or length < SHORTEST.get(opcode, 0):
            raise ValueError("a record of a length that cannot be")
        found.append((opcode, begin, position))
    return found
