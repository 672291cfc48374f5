# SPDX-License-Identifier: BSD-3-Clause
"""Copies what is readable of a recording into a sound, indexed and compressed file."""

from __future__ import annotations

from pathlib import Path

from session_log.errors import OutputFailed, RecordingFailed
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import ACCOUNT, MessageCounter, RecordingSummary
from session_log.mcap_file.writer import SessionWriter

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
    try:
        writer = SessionWriter(target)
        try:
            with writer:
                return _copy(reader, writer)
        except BaseException:
            target.unlink(missing_ok=True)  # half a copy looks like a whole recording
            raise
    except RecordingFailed as error:
        raise OutputFailed(target, error.cause) from error


def _copy(reader: SessionReader, writer: SessionWriter) -> RecordingSummary:
    counter = MessageCounter()
    for index, message in enumerate(counter.counting(reader.messages())):
        writer.add(message)
        if index % COMMIT == COMMIT - 1:
            writer.commit()
    result = counter.summary(reader.condition)
    for name, values in reader.condition.metadata:
        writer.add_metadata(name, values)
    writer.add_metadata(ACCOUNT, _account(reader, result))
    return result


def _account(reader: SessionReader, result: RecordingSummary) -> dict[str, str]:
    condition = result.condition
    return {
        "from": reader.path.name,
        "was_closed": str(condition.is_closed),
        "messages": str(result.messages),
        "missing_messages": str(result.missing),
        "unreadable_bytes": str(sum(d.length for d in condition.damage)),
        "damage": "; ".join(
            f"{d.length} B at {d.offset}: {d.what}" for d in condition.damage[:MOST_DAMAGES]
        ),
    }
