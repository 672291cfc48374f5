# SPDX-License-Identifier: BSD-3-Clause
"""Walks the records of an MCAP file and finds the way again after a damaged stretch."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import BinaryIO

from session_log.types import Damage

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")  # opcode, length of the body
LONGEST = 1 << 31  # [B] no record of ours is longer
WINDOW = 1 << 20  # [B] searched at once for the next record

HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06
MESSAGE_INDEX, METADATA, DATA_END = 0x07, 0x0C, 0x0F
CHECKSUM = 0x80  # ours: MCAP leaves opcodes from 0x80 on to applications, and readers skip them
CHECKSUM_BODY = struct.Struct("<QI")  # how many bytes before this record it covers, their CRC-32
SHORTEST = {HEADER: 8, FOOTER: 20, SCHEMA: 14, CHANNEL: 16, MESSAGE: 22, CHUNK: 40, DATA_END: 4}
_CANDIDATE = re.compile(rb"(?=[\x01-\x0f\x80][\s\S]{4}\x00{4})")  # opcode, length below 4 GiB


@dataclass(frozen=True)
class McapRecord:
    """One record as it stands in the file."""

    offset: int  # [B]
    opcode: int
    body: bytes


class RecordWalker:
    """Iterates over the records of an open file.

    Args:
        file: Open for reading in binary, seekable.
        accepts: Tells whether a record makes sense, by opcode, length [B] and start of its body.
    """

    def __init__(self, file: BinaryIO, accepts: Callable[[int, int, bytes], bool]) -> None:
        self._file, self._accepts = file, accepts
        self._size = file.seek(0, 2)
        self._known = (-1, 0, 0)  # position, opcode and length of the sound record found last

    def walk(self, start: int) -> Iterator[McapRecord | Damage]:
        """Yield every record from `start` on, and a `Damage` for each stretch that is none.

        What follows a file's ending is one stretch.
        """
        position = start
        while position < self._size:
            record = self._read(position)
            end = position if record is None else position + HEAD.size + len(record.body)
            is_sound = record is not None and self._leads_on(end)
            found = end if is_sound else self._find(position + 1)
            if record is not None and found >= end:
                yield record
                position = end
                if record.opcode == FOOTER:
                    rest = position + len(MAGIC)
                    if rest < self._size:
                        yield Damage(rest, self._size - rest, "not read: after the file's ending")
                    return
            else:  # none, or one whose damaged length would swallow sound records
                yield _damage(position, found, self._size)
                position = found

    def _read(self, position: int) -> McapRecord | None:
        length = self._length(position)
        if length is None:
            return None
        self._file.seek(position + HEAD.size)
        opcode = self._opcode
        body = self._file.read(length)
        return McapRecord(position, opcode, body)

    def _length(self, position: int) -> int | None:
        """Length of the body of the record at a position; None if there is no sound record."""
        if position == self._known[0]:  # it was read as the follower of the one before
            _, self._opcode, length = self._known
            return length
        self._file.seek(position)
        head = self._file.read(HEAD.size + 22)
        if len(head) < HEAD.size:
            return None
        self._opcode, length = HEAD.unpack_from(head)
        fits = length <= LONGEST and position + HEAD.size + length <= self._size
        if not fits or length < SHORTEST.get(self._opcode, 0):
            return None
        if not self._accepts(self._opcode, length, head[HEAD.size :]):
            return None
        if self._opcode == FOOTER and not self._is_end(position + HEAD.size + length):
            return None  # one wrong bit makes it of a chunk, and would hide what follows
        self._known = position, self._opcode, length
        return length

    def _find(self, start: int) -> int:
        """Find the next position at which two sound records follow each other, or the end."""
        for position in self._candidates(start):
            length = self._length(position)
            if length is None:
                continue
            if self._leads_on(position + HEAD.size + length):
                return position
        return self._size

    def _leads_on(self, end: int) -> bool:
        """Whether a sound record, or the end of the file, follows a record that ends there."""
        return self._length(end) is not None or self._is_end(end)

    def _candidates(self, start: int) -> Iterator[int]:
        while start < self._size:
            self._file.seek(start)
            window = self._file.read(WINDOW + HEAD.size)
            for match in _CANDIDATE.finditer(window):
                if match.start() < WINDOW:
                    yield start + match.start()
            start += WINDOW

    def _is_end(self, position: int) -> bool:
        """Whether the file ends there, or its last bytes begin, which may be cut off."""
        self._file.seek(position)
        return MAGIC.startswith(self._file.read(len(MAGIC)))


def _damage(position: int, found: int, size: int) -> Damage:
    what = "cut off inside a record" if found == size else "not readable as records"
    return Damage(position, found - position, what)
