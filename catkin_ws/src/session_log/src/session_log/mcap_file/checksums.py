# SPDX-License-Identifier: BSD-3-Clause
"""Holds records back until the seal of their commit shows that nobody changed them.

MCAP has a checksum over the whole file, which a killed recorder never writes, and none per message:
one flipped bit in a length makes a shorter message that looks sound. So each commit ends with a
seal. What no seal vouches for is left out, but for the end of a file, which may have been cut off
before its seal, and for files of other writers, which have none.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from typing import BinaryIO

from session_log.mcap_file.records import SEAL_BODY, Record
from session_log.types import Damage

MOST_HELD = 4 << 20  # [B] held back at most; our writer seals far sooner
_PIECE = 1 << 20  # [B] read at once


class Held:
    """Records in the order of the file that wait for their seal.

    Args:
        file: Open for reading in binary, seekable.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._records: list[Record] = []
        self._size = 0  # [B]
        self._is_sealed = False  # a seal was met
        self.broken: Damage | None = None  # what the last seal did not vouch for

    def hold(self, record: Record) -> Iterator[Record]:
        """Keep a record; yields older ones where too much waits for a seal that does not come."""
        if self._size > MOST_HELD:
            yield from self.release()
        self._records.append(record)
        self._size += len(record.body)

    def release(self) -> Iterator[Record]:
        """Yield all, unsealed as they are."""
        records, self._records, self._size = self._records, [], 0
        yield from records

    def open(self, seal: Record) -> Iterator[Record]:
        """Yield what a seal vouches for; `broken` then tells what it does not, and is left out."""
        length, expected = SEAL_BODY.unpack_from(seal.body)
        begin = seal.offset - length
        held = list(self.release())
        is_sound = begin >= 0 and checksum(self._file, begin, length) == expected
        self._is_sealed = True
        first_kept = begin if is_sound else seal.offset
        kept = [r for r in held if r.offset >= first_kept]
        lost = len(held) - len(kept)
        self.broken = None
        if lost or not is_sound:
            first = min(held[0].offset if lost else first_kept, max(begin, 0))
            self.broken = _lost(first, first_kept, lost)
        yield from kept

    def finish(self, end: Record) -> Iterator[Record]:
        """Yield what waits at the sound end of the data; where there are seals, its own is lost."""
        held = list(self.release())
        self.broken = None
        if self._is_sealed and held:
            self.broken = _lost(held[0].offset, end.offset, len(held))
            return
        yield from held


def checksum(file: BinaryIO, begin: int, length: int) -> int:
    """CRC-32 of a stretch of a file [B]."""
    file.seek(begin)
    found = 0
    while length > 0 and (piece := file.read(min(length, _PIECE))):
        found = zlib.crc32(piece, found)
        length -= len(piece)
    return found


def _lost(begin: int, end: int, count: int) -> Damage:
    words = f"changed since it was written: {count} records left out"
    return Damage(begin, end - begin, words)
