# SPDX-License-Identifier: BSD-3-Clause
"""Streams a recording in constant memory, also a damaged one, and says what is lost."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.records import Channel, Header, Metadata, Schema

from session_log.errors import NotASession, SessionMissing
from session_log.mcap_file import checksums, records
from session_log.mcap_file.chunk import UNREADABLE, content_of, places_of
from session_log.mcap_file.condition import FileCondition
from session_log.mcap_file.records import CHECKSUM_BODY, MAGIC, McapRecord, RecordWalker
from session_log.types import MESSAGE_ENCODING, SCHEMA_ENCODING, Damage, Message, MessageSource
from typed_config import RECORDING, newest_recording

_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_FOOTER_SIZE = records.HEAD.size + records.SHORTEST[records.FOOTER]
_INDEX = struct.Struct("<HI")  # channel, size of the entries [B]
_OURS = {  # among the data
    *(records.HEADER, records.SCHEMA, records.CHANNEL, records.CHUNK),
    *(records.METADATA, records.CHECKSUM),
}
_EARLIEST = 946_684_800_000_000_000  # [ns] the year 2000; times before it are damage
_LATEST = 4_102_444_800_000_000_000  # [ns] the year 2100


class SessionReader:
    """One recording, for any number of passes.

    Args:
        path: The MCAP file, or the folder of a session, of which the newest recording is read.
        tolerant: Also read a file whose very beginning is damaged.

    Raises:
        SessionMissing: There is no such file, or it cannot be read.
        NotASession: The file is something else.
    """

    def __init__(self, path: Path | str, *, tolerant: bool = False) -> None:
        self.path = _find(Path(path))
        self.condition = FileCondition()
        begin = _beginning(self.path)
        if begin != MAGIC and not tolerant:
            raise NotASession(self.path, f"begins with {begin!r}" if begin else "is empty")
        self._start = len(MAGIC) if begin == MAGIC else 0

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Message]:
        """Yield every readable message of the given topics (None: all) in the order of the file.

        Raises:
            SessionMissing: The file cannot be read any further.
        """
        try:  # errors of the caller do not come here
            with _open(self.path) as file:
                yield from _Pass(file, self._start, self._new_condition()).messages(topics)
        except OSError as error:
            raise _unreadable(self.path, error) from error

    def _new_condition(self) -> FileCondition:
        self.condition = FileCondition(size=self.path.stat().st_size)
        return self.condition


class _Pass:
    """One pass through an open file."""

    def __init__(self, file: BinaryIO, start: int, condition: FileCondition) -> None:
        self._file, self._start, self._condition = file, start, condition
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, MessageSource] = {}
        self._checksum = zlib.crc32(MAGIC)
        self._is_data_over = False
        self._has_chunks = False
        self._summary = condition.size  # [B] where it begins, if known
        self._from_ending: dict[int, MessageSource] = {}
        self._named_at = -1  # [B] of the last record that named a topic
        self._walker = RecordWalker(file, self._accepts)
        self._held = checksums.RecordBuffer(file)

    def messages(self, topics: Collection[str] | None) -> Iterator[Message]:
        if self._condition.size >= self._start + _FOOTER_SIZE + len(MAGIC):
            self._learn_from_ending()
        for item in self._walker.walk(self._start):
            if isinstance(item, Damage):
                self._condition.damage.append(item)
            else:
                yield from self._take(item, topics)
        yield from self._given(self._held.release(), topics)

    def _take(self, record: McapRecord, topics: Collection[str] | None) -> Iterator[Message]:
        if not self._belongs(record):
            self._lose(record, "damaged " + _name(record.opcode))
        elif record.opcode in (records.MESSAGE, records.METADATA):
            yield from self._given(self._held.hold(record), topics)
        elif record.opcode == records.CHECKSUM and len(record.body) == CHECKSUM_BODY.size:
            opened = self._held.open(record, is_foreign=self._condition.is_foreign)
            yield from self._given(opened, topics)
            self._note_broken()
        elif record.opcode == records.DATA_END:
            yield from self._given(self._held.finish(record), topics)
            self._note_broken()
            self._note(record)
        elif record.opcode == records.CHUNK:
            yield from self._given(self._held.release(), topics)
            yield from self._chunk(record, topics)
        else:
            self._note(record)
        if not self._is_data_over:
            head = records.HEAD.pack(record.opcode, len(record.body))
            self._checksum = zlib.crc32(record.body, zlib.crc32(head, self._checksum))

    def _belongs(self, record: McapRecord) -> bool:
        """Whether our writer writes such a record at this place; of others nothing is known.

        One wrong bit makes another record of a chunk, or of an index a message.
        """
        is_ending = self._is_data_over or record.offset >= self._summary
        if is_ending or self._condition.is_foreign:
            return True
        opcode, length = record.opcode, len(record.body)
        if opcode == records.MESSAGE:
            return not self._has_chunks
        if opcode == records.MESSAGE_INDEX:
            is_whole = length >= _INDEX.size
            return is_whole and length == _INDEX.size + _INDEX.unpack_from(record.body)[1]
        if opcode in (records.DATA_END, records.FOOTER):
            return length == records.SHORTEST[opcode]
        return opcode in _OURS

    def _given(
        self, released: Iterator[McapRecord], topics: Collection[str] | None
    ) -> Iterator[Message]:
        for record in released:
            if record.opcode == records.METADATA:
                self._note(record)
                continue
            message = self._message(record.body)
            if message and (topics is None or message.source.topic in topics):
                yield message

    def _note_broken(self) -> None:
        broken, damage = self._held.broken, self._condition.damage
        if broken is None:
            return
        while damage and damage[-1].offset >= broken.offset:
            damage.pop()  # part of it
        end = broken.offset + broken.length
        what = broken.what
        if broken.offset <= self._named_at < end and not self._from_ending:
            what += "; names of topics may be wrong"
        # a damaged checksum can cover what was named before
        begin = max(broken.offset, damage[-1].offset + damage[-1].length if damage else 0)
        if begin < end:
            damage.append(Damage(begin, end - begin, what))
        self._channels.update(self._from_ending)  # those of the broken stretch may be wrong

    def _note(self, record: McapRecord) -> None:
        try:
            if record.opcode == records.SCHEMA:
                schema = Schema.read(_stream(record.body))
                self._schemas[schema.id] = schema
            elif record.opcode == records.CHANNEL:
                self._add_channel(Channel.read(_stream(record.body)))
                self._named_at = record.offset
            elif record.opcode == records.HEADER:
                self._condition.library = Header.read(_stream(record.body)).library or "unknown"
            elif record.opcode == records.METADATA:
                entry = Metadata.read(_stream(record.body))
                self._condition.metadata.append((entry.name, entry.metadata))
            elif record.opcode == records.DATA_END:
                self._end(struct.unpack_from("<I", record.body)[0])
            elif record.opcode == records.FOOTER:
                self._condition.is_closed = True
        except UNREADABLE:
            self._lose(record, "damaged " + _name(record.opcode))

    def _end(self, checksum: int) -> None:
        self._is_data_over = True
        if checksum:
            self._condition.checksum = "good" if checksum == self._checksum else "wrong"

    def _add_channel(self, channel: Channel) -> None:
        schema = self._schemas.get(channel.schema_id)
        message_encoding, schema_encoding = self._encodings(channel, schema)
        self._channels[channel.id] = MessageSource(
            topic=channel.topic,
            datatype=schema.name if schema else "",
            md5sum=channel.metadata.get("md5sum", ""),
            definition=schema.data.decode(errors="replace") if schema else "",
            publisher=channel.metadata.get("callerid", ""),
            is_latched=channel.metadata.get("latching") == "1",
            message_encoding=message_encoding,
            schema_encoding=schema_encoding,
        )

    def _encodings(self, channel: Channel, schema: Schema | None) -> tuple[str, str]:
        """Encoding of the messages and of their schema.

        Another than that of ROS 1 is damage in a file of ours, and where the channel has an MD5
        sum, which only ROS 1 knows.
        """
        if self._condition.is_ours or "md5sum" in channel.metadata:
            return MESSAGE_ENCODING, SCHEMA_ENCODING
        lost = SCHEMA_ENCODING if channel.message_encoding == MESSAGE_ENCODING else ""
        return channel.message_encoding, schema.encoding if schema else lost

    def _message(self, body: bytes) -> Message | None:
        channel, sequence, log_time, published = _MESSAGE.unpack_from(body)
        source = self._channels.get(channel)
        if source is None:
            return None
        published = 0 if published == log_time else published
        return Message(source, body[_MESSAGE.size :], log_time, sequence, published)

    def _chunk(self, chunk: McapRecord, topics: Collection[str] | None) -> Iterator[Message]:
        try:
            content = content_of(chunk)
            places = places_of(content)
        except UNREADABLE:
            self._lose(chunk, "damaged chunk")
            return
        self._has_chunks = True
        nameless = 0
        for opcode, begin, end in places:
            if opcode == records.MESSAGE:
                channel, sequence, log_time, published = _MESSAGE.unpack_from(content, begin)
                source = self._channels.get(channel)
                nameless += source is None
                if source and (topics is None or source.topic in topics):
                    data = content[begin + _MESSAGE.size : end]
                    published = 0 if published == log_time else published
                    yield Message(source, data, log_time, sequence, published)
            elif opcode in (records.SCHEMA, records.CHANNEL):
                self._note(McapRecord(chunk.offset, opcode, content[begin:end]))
        if nameless:
            self._lose(chunk, f"{nameless} messages of topics whose names are lost")

    def _lose(self, record: McapRecord, what: str) -> None:
        begin, end = record.offset, record.offset + records.HEAD.size + len(record.body)
        damage = self._condition.damage
        last = damage[-1] if damage else None
        if last and (last.offset + last.length, last.what) == (begin, what):
            begin = damage.pop().offset  # a lost index has a record for each chunk
        damage.append(Damage(begin, end - begin, what))

    def _accepts(self, opcode: int, length: int, begin: bytes) -> bool:
        is_foreign = self._condition.is_foreign
        if opcode == records.MESSAGE:
            channel, _, log_time, _ = _MESSAGE.unpack_from(begin)
            earliest = 0 if is_foreign else _EARLIEST  # a simulated clock begins at zero
            return channel in self._channels and earliest <= log_time < _LATEST
        if opcode == records.CHECKSUM and length == CHECKSUM_BODY.size:
            return True
        is_private = is_foreign and opcode >= records.CHECKSUM  # to another program
        return is_private or records.HEADER <= opcode <= records.DATA_END

    def _learn_from_ending(self) -> None:
        """Take schemas and channels from the summary, if any: they may be damaged above it."""
        footer_at = self._condition.size - _FOOTER_SIZE - len(MAGIC)
        self._file.seek(footer_at)
        ending = self._file.read()
        opcode, length, summary, _, checksum = struct.unpack_from("<BQQQI", ending)
        if (opcode, length) != (records.FOOTER, 20) or not self._start < summary < footer_at:
            return
        covered = self._condition.size - len(MAGIC) - 4 - summary
        if checksum and checksums.checksum(self._file, summary, covered) != checksum:
            return
        for item in self._walker.walk(summary):
            if isinstance(item, McapRecord) and item.opcode in (records.SCHEMA, records.CHANNEL):
                self._note(item)
        self._from_ending = dict(self._channels)
        self._summary = summary


def _stream(body: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(body))


def _name(opcode: int) -> str:
    names = {records.SCHEMA: "schema", records.CHANNEL: "channel", records.METADATA: "metadata"}
    return names.get(opcode, f"record {opcode}")


def _find(path: Path) -> Path:
    try:
        if path.is_dir():
            if (found := newest_recording(path)) is None:
                raise SessionMissing(path, f"a folder without {RECORDING}")
            return found
        is_there = path.exists()
    except OSError as error:  # it may not be looked into
        raise _unreadable(path, error) from error
    if not is_there:
        raise SessionMissing(path, "no such file or folder")
    return path


def _open(path: Path) -> BinaryIO:
    try:
        return path.open("rb", buffering=1 << 20)
    except OSError as error:
        raise _unreadable(path, error) from error


def _beginning(path: Path) -> bytes:
    try:
        with _open(path) as file:
            return file.read(len(MAGIC))
    except OSError as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: OSError) -> SessionMissing:
    return SessionMissing(path, error.strerror or "cannot be read")
