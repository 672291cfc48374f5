# SPDX-License-Identifier: BSD-3-Clause
"""Writes one MCAP file: profile ros1, schemas ros1msg, raw message bytes in chunks of zstd.

Each commit ends a chunk, so the file can be read up to its last commit. A chunk has a checksum.
What lies outside of chunks gets one of ours: damage then shows in a file that was never closed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, cast

from mcap.data_stream import RecordBuilder
from mcap.records import ChunkIndex
from mcap.writer import CompressionType, IndexType
from mcap.writer import Writer as McapWriter

from session_log.errors import RecordingFailed
from session_log.mcap_file.durable_stream import DurableStream
from session_log.mcap_file.encoding import WrongEncoding
from session_log.mcap_file.records import CHECKSUM, CHECKSUM_BODY
from session_log.types import Message, MessageSource

LIBRARY = "session_log"


class LibraryWriter(McapWriter):
    """The library's writer, which can also write a record of ours among its own."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._Writer__chunk_indices = _PackedIndex()

    def add_record(self, opcode: int, body: bytes) -> None:
        """Write a record that has no part in index and statistics."""
        builder = self._Writer__record_builder  # type: ignore[attr-defined]
        builder.start_record(opcode)
        builder.write(body)
        builder.finish_record()
        self._Writer__flush()  # type: ignore[attr-defined]


class _PackedIndex:
    """Index of the chunks as bytes: as objects it takes 60 MB for each hour of a session."""

    def __init__(self) -> None:
        self._records = RecordBuilder()

    def append(self, index: ChunkIndex) -> None:
        index.write(self._records)

    def __iter__(self) -> Iterator[_PackedIndex]:
        yield self

    def write(self, summary: RecordBuilder) -> None:
        summary.write(self._records.end())


class SessionWriter:
    """One recording being written. Not thread-safe: one owner.

    Args:
        path: File to create; it must not exist.
        library: What the file says that it was written by; begins with ours.

    Raises:
        RecordingFailed: The file cannot be created or written.
    """

    def __init__(self, path: Path, library: str = LIBRARY) -> None:
        self.path = path
        self._stream = DurableStream(path)
        self._mcap = LibraryWriter(
            cast("IO[Any]", self._stream),
            compression=CompressionType.ZSTD,
            index_types=IndexType.ALL,
            enable_data_crcs=True,
        )
        self._channels: dict[MessageSource, int] = {}
        self._schemas: dict[tuple[str, str], int] = {}
        self._mcap.start(profile="ros1", library=library)
        try:
            self.commit()
        except RecordingFailed:  # the caller tries again with a file of another name
            self.abandon()
            with suppress(OSError):  # a file system that has become read-only
                path.unlink(missing_ok=True)
            raise

    def add(self, message: Message) -> None:
        """Take one message for the next commit.

        Raises:
            WrongEncoding: It is none of ROS 1.
        """
        self._mcap.add_message(
            channel_id=self._channel(message.source),
            log_time=message.log_time,
            publish_time=message.publish_time or message.log_time,
            sequence=message.sequence & 0xFFFFFFFF,
            data=message.data,
        )

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Take named facts about the session for the next commit."""
        start = self._stream.tell()
        self._mcap.add_metadata(name, dict(values))
        length, checksum = self._stream.tell() - start, self._stream.checksum(start)
        self._mcap.add_record(CHECKSUM, CHECKSUM_BODY.pack(length, checksum))

    def commit(self) -> None:
        """Hand everything taken to the kernel; it then survives the death of this process.

        Raises:
            RecordingFailed: It was not written and is kept for the next commit.
        """
        self._mcap.flush()

    def sync(self) -> None:
        """Hand everything committed to the disk.

        Raises:
            RecordingFailed: The disk refused it.
        """
        self._stream.sync()

    def check(self) -> None:
        """See whether the file is still there.

        Raises:
            RecordingFailed: It was deleted.
        """
        self._stream.check()

    @property
    def committed(self) -> int:
        """Size of the file [B]."""
        return self._stream.committed

    def close(self) -> None:
        """Write statistics and index, then close.

        Raises:
            RecordingFailed: The ending could not be written; the messages before it are readable.
        """
        try:
            self._mcap.finish()
            self._stream.flush()
            self._stream.sync()
        finally:
            self._stream.close()

    def abandon(self) -> None:
        """Close the file as it is, without an ending."""
        self._stream.close()

    def __enter__(self) -> SessionWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _channel(self, source: MessageSource) -> int:
        channel = self._channels.get(source)
        if channel is None:
            if not source.is_ros1:
                raise WrongEncoding(source)
            channel = self._mcap.register_channel(
                topic=source.topic,
                message_encoding=source.message_encoding,
                schema_id=self._schema(source),
                metadata={
                    "md5sum": source.md5sum,
                    "callerid": source.publisher,
                    "latching": "1" if source.is_latched else "0",
                },
            )
            self._channels[source] = channel
        return channel

    def _schema(self, source: MessageSource) -> int:
        key = (source.datatype, source.definition)
        if key not in self._schemas:
            self._schemas[key] = self._mcap.register_schema(
                name=source.datatype,
                encoding=source.schema_encoding,
                data=source.definition.encode(),
            )
        return self._schemas[key]
