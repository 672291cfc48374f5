# SPDX-License-Identifier: BSD-3-Clause
"""Holds records back until the checksum of their commit shows that nobody changed them.

MCAP has a checksum over the whole file, which a killed recorder never writes, and none per message:
one flipped bit in a length makes a shorter message that looks sound. So each commit ends with a
checksum. What no checksum confirms is left out. Two things are read without one: the end of a file,
which may have been cut off before its checksum, and files of other writers, which have none. They
may have a record of their own that looks like one, so there one has to be right before any counts.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from typing import BinaryIO

from session_log.mcap_file.records import CHECKSUM_BODY, McapRecord
from session_log.types import Damage

MOST_HELD = 4 << 20  # [B] held back at most; our writer adds checksums far sooner
_PIECE = 1 << 20  # [B] read at once


class RecordBuffer:
    """Records in the order of the file that wait for their checksum.

    Args:
        file: Open for reading in binary, seekable.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._records: list[McapRecord] = []
        self._size = 0  # [B]
        self._has_checksums = False  # one was met
        self.broken: Damage | None = None  # what the last checksum did not confirm

    def hold(self, record: McapRecord) -> Iterator[McapRecord]:
        """Keep a record; yields older ones where too much waits for a checksum."""
        if self._size > MOST_HELD:
            yield from self.release()
        self._records.append(record)
        self._size += len(record.body)

    def release(self) -> Iterator[McapRecord]:
        """Yield all, unchecked as they are."""
        records, self._records, self._size = self._records, [], 0
        yield from records

    def open(self, record: McapRecord, *, is_foreign: bool) -> Iterator[McapRecord]:
        """Yield what a checksum confirms; `broken` is the damage that is left out.

        Args:
            record: The checksum.
            is_foreign: The file seems to be of another writer.
        """
        length, expected = CHECKSUM_BODY.unpack_from(record.body)
        begin = record.offset - length
        held = list(self.release())
        is_sound = begin >= 0 and checksum(self._file, begin, length) == expected
        self.broken = None
        if is_foreign and not (is_sound or self._has_checksums):
            yield from held
            return
        self._has_checksums = True
        first_kept = begin if is_sound else record.offset
        kept = [r for r in held if r.offset >= first_kept]
        lost = len(held) - len(kept)
        if lost or not is_sound:
            first = min(held[0].offset if lost else first_kept, max(begin, 0))
            self.broken = _lost(first, first_kept, lost)
        yield from kept

    def finish(self, end: McapRecord) -> Iterator[McapRecord]:
        """Yield what waits at the sound end of the data; with checksums, its own is lost."""
        held = list(self.release())
        self.broken = None
        if self._has_checksums and held:
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
