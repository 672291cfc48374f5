# SPDX-License-Identifier: BSD-3-Clause
"""Copies what is readable of a recording into a sound, indexed and compressed file."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain, islice
from pathlib import Path

from session_log.errors import OutputFailed, RecordingFailed
from session_log.mcap_file.reader import FileCondition, SessionReader
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
                _copy(chain(first, messages), writer)
                return _finish(counter.summary(), reader.path, writer)
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


def _copy(messages: Iterable[Message], writer: SessionWriter) -> None:
    for index, message in enumerate(messages):
        writer.add(message)
        if index % COMMIT == COMMIT - 1:
            writer.commit()


def _finish(result: RecordingSummary, source: Path, writer: SessionWriter) -> RecordingSummary:
    for name, values in result.condition.metadata:
        writer.add_metadata(name, values)
    writer.add_metadata(ACCOUNT, _account(result, source))
    return result


def _account(result: RecordingSummary, source: Path) -> dict[str, str]:
    condition = result.condition
    return {
        "from": source.name,
        "was_closed": str(condition.is_closed),
        "messages": str(result.messages),
        "missing_messages": str(result.missing),
        "unreadable_bytes": str(sum(d.length for d in condition.damage)),
        "damage": "; ".join(
            f"{d.length} B at {d.offset}: {d.what}" for d in condition.damage[:MOST_DAMAGES]
        ),
    }
