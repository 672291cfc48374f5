# SPDX-License-Identifier: BSD-3-Clause
"""Copies what is readable of a recording into a sound, indexed and compressed file."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain, islice
from pathlib import Path

from session_log.errors import OutputFailed, RecordingFailed
from session_log.mcap_file.condition import FileCondition
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import ACCOUNT, MessageCounter, RecordingSummary
from session_log.mcap_file.writer import LIBRARY, SessionWriter
from session_log.types import Message

COMMIT = 2000  # messages in one: they wait in memory
MOST_DAMAGES = 100  # places of damage that the copy names


def recover(reader: SessionReader, target: Path) -> RecordingSummary:
    """Write every readable message, and all metadata, to a new file.

    Args:
        reader: The recording, sound or not.
        target: File to create; it must not exist.

    Raises:
        WrongEncoding: It holds messages that are none of ROS 1; nothing is written.
        OutputFailed: The file exists already or cannot be written.
    """
    counter = MessageCounter(reader)
    messages = counter.messages()
    first = list(islice(messages, 1))  # what wrote the file is known now
    try:
        writer = SessionWriter(target, _library(reader.condition))
        try:
            with writer:
                _copy(chain(first, messages), reader.condition.metadata, writer)
                result = counter.summary()
                writer.add_metadata(ACCOUNT, _account(result, reader.path))
                return result
        except BaseException:
            target.unlink(missing_ok=True)  # half a copy looks like a whole recording
            raise
    except RecordingFailed as error:
        raise OutputFailed(target, error.cause) from error


def _library(condition: FileCondition) -> str:
    """What the copy says that it was written by: numbers and order are those of the original."""
    if condition.is_foreign:
        return f"{LIBRARY}, copied from {condition.library}"
    return condition.library or LIBRARY


def _copy(
    messages: Iterable[Message], metadata: list[tuple[str, dict[str, str]]], writer: SessionWriter
) -> None:
    """Write messages, and metadata, which grow as messages are read, each in its place."""
    copied = 0
    for index, message in enumerate(messages):
        copied = _copy_metadata(metadata, copied, writer)
        writer.add(message)
        if index % COMMIT == COMMIT - 1:
            writer.commit()
    _copy_metadata(metadata, copied, writer)


def _copy_metadata(
    metadata: list[tuple[str, dict[str, str]]], copied: int, writer: SessionWriter
) -> int:
    """Write what was read since; gives how many are written now."""
    if len(metadata) > copied:
        writer.commit()  # or it would lie in front of the messages that wait
    for name, values in metadata[copied:]:
        writer.add_metadata(name, values)
    return len(metadata)


def _account(result: RecordingSummary, source: Path) -> dict[str, str]:
    condition = result.condition
    return {
        "from": source.name,
        "was_closed": str(condition.is_closed),
        "checksum": condition.checksum,
        "messages": str(result.messages),
        "missing_messages": str(result.missing),
        "unreadable_bytes": str(sum(d.length for d in condition.damage)),
        "damage": "; ".join(map(str, condition.damage[:MOST_DAMAGES])),
    }
