# SPDX-License-Identifier: BSD-3-Clause
"""An output stream that a full disk cannot leave with half a record."""

from __future__ import annotations

import errno
import os
import zlib
from collections.abc import Callable
from pathlib import Path

from session_log.errors import RecordingFailed


class DurableStream:
    """Collects bytes in memory and hands them to the file in one commit, whole or not at all.

    What a failed commit did not write stays here and is tried again by the next one, so the
    records before it remain readable and the records in it are not lost.

    Raises:
        RecordingFailed: The file cannot be created; it must not exist yet.
    """

    def __init__(self, path: Path, write: Callable[[int, memoryview], int] = os.write) -> None:
        self.path = path
        self._write = write
        self._pending = bytearray()
        self._committed = 0  # [B] in the file
        try:
            self._fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise RecordingFailed(path, error) from error

    def write(self, data: bytes) -> int:
        """Take bytes for the next commit."""
        self._pending += data
        return len(data)

    def checksum(self, start: int) -> int:
        """CRC-32 of what was taken since a position [B], none of which may be committed yet."""
        with memoryview(self._pending) as view:
            return zlib.crc32(view[start - self._committed :])

    def tell(self) -> int:
        """Position in the file, pending bytes included [B]."""
        return self._committed + len(self._pending)

    @property
    def committed(self) -> int:
        """What the file holds [B]; SIGKILL cannot take it back."""
        return self._committed

    def flush(self) -> None:
        """Write all pending bytes.

        Raises:
            RecordingFailed: Nothing of them was written, or it was cut off again.
        """
        if not self._pending:
            return
        try:
            with memoryview(self._pending) as view:
                self._write_all(view)
        except OSError as error:
            self._cut_back()
            raise RecordingFailed(self.path, error) from error
        self._committed += len(self._pending)
        self._pending.clear()

    def sync(self) -> None:
        """Wait until the disk holds what was committed, so that a power failure cannot take it.

        Raises:
            RecordingFailed: The disk refused it, or the file was deleted.
        """
        try:
            os.fdatasync(self._fd)
        except OSError as error:
            raise RecordingFailed(self.path, error) from error
        self.check()

    def check(self) -> None:
        """See whether the file still has a name, without waiting for the disk.

        Raises:
            RecordingFailed: It was deleted.
        """
        try:
            if os.fstat(self._fd).st_nlink == 0:
                raise OSError(errno.ENOENT, "the file was deleted while it was being written")
        except OSError as error:
            raise RecordingFailed(self.path, error) from error

    def close(self) -> None:
        """Close the file; pending bytes are not written."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _write_all(self, view: memoryview) -> None:
        position = 0
        while position < len(view):
            position += self._write(self._fd, view[position:])

    def _cut_back(self) -> None:
        try:
            os.ftruncate(self._fd, self._committed)
            os.lseek(self._fd, self._committed, os.SEEK_SET)
        except OSError:
            return  # the file is gone or the disk is: the commit's own error is the one to report
