# SPDX-License-Identifier: BSD-3-Clause
"""Writes a recording as another program does: by the library alone, in any encoding."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from session_log.mcap_file.writer import LibraryWriter

NOW = 1_795_200_000_000_000_000  # [ns]
EARLIER = 1_000_000  # [ns] that a message was published before it was logged


def write_foreign(
    path: Path,
    topics: Iterable[str] = ("/t",),
    message_encoding: str = "cdr",
    schema_encoding: str = "ros2msg",
    *,
    times: Sequence[int] = (NOW,),
    private: tuple[int, bytes] | None = None,
    **options: object,
) -> Path:
    """One std_msgs/String a topic and log time [ns], published a millisecond before.

    They are numbered by sevens. A record of the program's own, of an opcode and a body, comes
    behind each. The options are those of the library's writer.
    """
    with path.open("wb") as file:
        writer = LibraryWriter(file, **options)
        writer.start(profile="", library="another")
        schema = writer.register_schema("std_msgs/String", schema_encoding, b"string data")
        for topic in topics:
            channel = writer.register_channel(topic, message_encoding, schema)
            for k, time in enumerate(times, 1):
                both = {"log_time": time, "publish_time": max(time - EARLIER, 0)}
                writer.add_message(channel, data=b"\1\0\0\0x", sequence=7 * k, **both)
                if private is not None:
                    writer.add_record(*private)
        writer.finish()
    return path
