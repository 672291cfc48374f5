# SPDX-License-Identifier: BSD-3-Clause
"""Writes a recording as it was made before chunks: plain records, a checksum at each commit."""

from __future__ import annotations

from pathlib import Path

from mcap.writer import CompressionType, IndexType

from session_log.mcap_file.durable_stream import DurableStream
from session_log.mcap_file.records import CHECKSUM, CHECKSUM_BODY
from session_log.mcap_file.writer import LIBRARY, LibraryWriter, SessionWriter
from session_log.types import Message

CHECKSUM_WITHIN = 1 << 20  # [B] after which one is due, commit or not


class UnchunkedWriter(SessionWriter):
    """The recorder's former writer; readers have to read what it left."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stream = DurableStream(path)
        self._covered = 0  # [B] up to where checksums reach
        self._mcap = LibraryWriter(
            self._stream,
            use_chunking=False,
            compression=CompressionType.NONE,
            index_types=IndexType.ALL,
            enable_data_crcs=True,
        )
        self._channels, self._schemas = {}, {}
        self._mcap.start(profile="ros1", library=LIBRARY)
        self.commit()

    def add(self, message: Message) -> None:
        super().add(message)
        if self._stream.tell() - self._covered > CHECKSUM_WITHIN:
            self._write_checksum()

    def add_metadata(self, name, values):
        self._mcap.add_metadata(name, dict(values))

    def commit(self) -> None:
        self._write_checksum()
        self._stream.flush()

    def close(self) -> None:
        self._write_checksum()
        super().close()

    def _write_checksum(self) -> None:
        end = self._stream.tell()
        if self._covered == end:
            return
        checksum = self._stream.checksum(self._covered)
        self._mcap.add_record(CHECKSUM, CHECKSUM_BODY.pack(end - self._covered, checksum))
        self._covered = self._stream.tell()
