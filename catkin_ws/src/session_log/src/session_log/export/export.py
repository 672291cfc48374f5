# SPDX-License-Identifier: BSD-3-Clause
"""Topics to CSV and Parquet, sound to WAV."""

from __future__ import annotations

import csv
import json
import math
from array import array
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from importlib.util import find_spec
from itertools import count
from operator import index
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, Protocol

from session_log.errors import OutputFailed, SessionLogError
from session_log.export.sound_stream import MOST_RATE, NANOSECONDS, SoundFile
from session_log.mcap_file.condition import FileCondition
from session_log.mcap_file.decoder import Decoder, MissingField, Undecodable, fields_of, is_time
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import MessageCounter, RecordingSummary
from session_log.types import Message

Format = Literal["csv", "parquet"]
FORMATS: Mapping[str, tuple[Format, ...]] = {
    "csv": ("csv",),
    "parquet": ("parquet",),
    "both": ("csv", "parquet"),
}
_OTHER_TYPES = (AttributeError, TypeError, ValueError, OverflowError)  # of the fields of the sound


class ParquetMissing(SessionLogError):
    """Parquet was asked for, and the package that writes it is not installed."""

    def __init__(self) -> None:
        super().__init__(
            "Parquet needs pyarrow, which is not installed: "
            "pip install -r requirements-parquet.txt, or use --format csv"
        )


@dataclass
class Export:
    """What was written."""

    recording: RecordingSummary  # of the exported topics; without steps of the clock
    rows: dict[Path, int] = field(default_factory=dict)
    sound: Path | None = None
    sound_start: int = 0  # [ns] since 1970, by the stamp of its first sample
    samples: int = 0
    lost_samples: int = 0  # with those of the time between two runs of the voice node
    unfilled_samples: int = 0  # of those lost: without silence in their place
    undecodable: int = 0
    topics: set[str] = field(default_factory=set)  # those that have a table
    unfit: dict[str, str] = field(default_factory=dict)  # why, of each topic's first such message


def export_topics(
    reader: SessionReader,
    folder: Path,
    topics: Collection[str],
    audio: str,
    formats: Collection[Format] = FORMATS["csv"],
) -> Export:
    """Write one table per topic, named after it, and the sound of the audio topic as audio.wav.

    Messages are written as they are read: memory does not grow with the recording. Files come into
    the folder when all of them are whole: of an export that is broken off nothing is left. Where a
    topic changes its type, what follows goes to a file of its own, numbered. So does a topic whose
    file would have the name of another's: /a_b beside /a/b.

    Args:
        reader: The recording, sound or not.
        folder: Where to write; made if it is not there.
        topics: Topics to write as tables.
        audio: Topic of the sound.
        formats: Of the tables.

    Raises:
        OutputFailed: The folder cannot be written.
        SessionMissing: The recording cannot be read any further.
        ParquetMissing: A format is Parquet, and pyarrow is not installed.
    """
    if "parquet" in formats and find_spec("pyarrow") is None:
        raise ParquetMissing
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(".part", "export_", folder) as parts:
            with ExitStack() as stack:
                result = _Exporter(Path(parts), stack, topics, audio, formats).run(reader)
            return _named(result, folder)
    except OSError as error:
        raise OutputFailed(folder, error) from error


def _named(export: Export, folder: Path) -> Export:
    """Move the files, which are whole now, into their folder."""
    rows = {path.replace(folder / path.name): count for path, count in export.rows.items()}
    sound = export.sound and export.sound.replace(folder / export.sound.name)
    return replace(export, rows=rows, sound=sound)


class _Table(Protocol):
    """One topic as a file."""

    path: Path
    rows: int

    def add(self, message: Message, content: Any) -> None: ...

    def __enter__(self) -> _Table: ...

    def __exit__(self, *_: object) -> None: ...


class _Exporter:
    def __init__(
        self,
        folder: Path,
        stack: ExitStack,
        topics: Collection[str],
        audio: str,
        formats: Collection[Format],
    ) -> None:
        self._folder, self._stack = folder, stack
        self._topics, self._audio, self._formats = topics, audio, formats
        self._decoder = Decoder()
        self._tables: dict[tuple[str, str, str], list[_Table]] = {}
        self._stems = file_stems(topics)
        self._used = set(self._stems.values())
        self._sound: SoundFile | None = None
        self._result = Export(RecordingSummary(FileCondition()))

    def run(self, reader: SessionReader) -> Export:
        counter = MessageCounter(reader)
        for message in reader.messages({*self._topics, self._audio}):
            counter.add(message)
            try:
                self._take(message)
            except (Undecodable, MissingField) as error:
                self._result.undecodable += 1
                self._result.unfit.setdefault(error.topic, str(error))
        # a few topics may be silent for long: what looks like steps of the clock is none
        self._result.recording = replace(counter.summary(), clock_steps=[])
        tables = [table for group in self._tables.values() for table in group]
        self._result.rows = {table.path: table.rows for table in tables}
        self._result.topics = {topic for topic, *_ in self._tables}
        if self._sound:
            result, sound = self._result, self._sound
            result.sound, result.samples = sound.path, sound.samples
            result.sound_start = sound.start
            result.lost_samples, result.unfilled_samples = sound.lost, sound.unfilled
        return self._result

    def _take(self, message: Message) -> None:
        topic = message.source.topic
        if topic in self._topics:
            content = self._decoder.decode(message)
            for table in self._tables_of(message):
                table.add(message, content)
        if topic == self._audio:
            try:
                self._decoder.read(message, partial(self._hear, message.log_time))
            except _OTHER_TYPES as error:
                raise Undecodable(message, error) from error

    def _hear(self, log_time: int, content: Any) -> None:
        stamp = content.header.stamp
        time = stamp.secs * NANOSECONDS + stamp.nsecs or log_time
        rate, first = index(content.rate), index(content.first_sample)
        samples = array("h", content.samples)
        if not 0 < rate <= MOST_RATE:
            raise ValueError(f"rate is {rate} Hz, allowed: 1 to {MOST_RATE}")
        if self._sound is None:
            path = self._folder / "audio.wav"
            self._sound = self._stack.enter_context(SoundFile(path, rate))
        if rate != self._sound.rate:
            raise ValueError(f"rate is {rate} Hz, in audio.wav it is {self._sound.rate}")
        self._sound.add(first, samples, time)

    def _tables_of(self, message: Message) -> list[_Table]:
        source = message.source
        # one MD5 sum has texts that differ in comments; where it is not given, fields may differ
        key = (source.topic, source.datatype, source.md5sum or source.definition)
        if key not in self._tables:
            stem = self._stems[source.topic]
            if any(topic == source.topic for topic, *_ in self._tables):
                stem = _free(stem, self._used)
                self._used.add(stem)
            opened = [self._open(stem, name, message) for name in self._formats]
            self._tables[key] = [self._stack.enter_context(table) for table in opened]
        return self._tables[key]

    def _open(self, stem: str, name: Format, first: Message) -> _Table:
        path = self._folder / f"{stem}.{name}"
        if name == "csv":
            return _CsvFile(path)
        from session_log.export.parquet import ParquetFile  # loads pyarrow, which takes its time

        return ParquetFile(path, first)


def file_stem(topic: str) -> str:
    """Name of a topic's file, without its ending."""
    return topic.strip("/").replace("/", "_")


def file_stems(topics: Collection[str]) -> dict[str, str]:
    """Name of each topic's file, without its ending; a name that is taken gets a number.

    The names depend on nothing but the topics: the first of them in order has the plain name.
    """
    plain = {file_stem(topic) for topic in topics}
    found: dict[str, str] = {}
    for topic in sorted(set(topics)):
        stem, used = file_stem(topic), set(found.values())
        found[topic] = _free(stem, used | plain) if stem in used else stem
    return found


def _free(stem: str, used: Collection[str]) -> str:
    return next(name for n in count(2) if (name := f"{stem}_{n}") not in used)


class _CsvFile:
    """One topic's table; its columns are those of the first message."""

    def __init__(self, path: Path) -> None:
        self.path, self.rows = path, 0
        self._file = path.open("w", newline="", encoding="utf-8")
        self._writer: csv.DictWriter[str] | None = None

    def add(self, message: Message, content: Any) -> None:
        fields = dict(flatten(content))
        if self._writer is None:
            columns = ["log_time", *fields]
            self._writer = csv.DictWriter(self._file, columns, extrasaction="ignore")
            self._writer.writeheader()
        self._writer.writerow({"log_time": seconds(message.log_time), **fields})
        self.rows += 1

    def __enter__(self) -> _CsvFile:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


def flatten(content: Any) -> Iterator[tuple[str, object]]:
    """Yield the fields of a decoded message as (dotted name, plain value); lists become JSON."""
    for name, value in fields_of(content):
        plain = value if isinstance(value, float) else _plain(value)
        yield name, json.dumps(plain) if isinstance(plain, list) else plain


def _plain(value: Any) -> object:
    """What JSON can hold of a value; a number that is not finite is null."""
    if isinstance(value, (int, str)):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, (bytes, bytearray)):
        return value.hex()
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if is_time(value):
        return seconds(value.secs * NANOSECONDS + value.nsecs)
    return {name: _plain(inner) for name, inner in fields_of(value)}


def seconds(nanoseconds: int) -> str:
    """A time or a duration in seconds, exact."""
    whole, rest = divmod(abs(nanoseconds), NANOSECONDS)
    return f"{'-' if nanoseconds < 0 else ''}{whole}.{rest:09d}"
