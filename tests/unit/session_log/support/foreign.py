# SPDX-License-Identifier: BSD-3-Clause
"""Writes a recording as another program does: by the library alone, in any encoding."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from mcap.writer import Writer

NOW = 1_795_200_000_000_000_000  # [ns]
EARLIER = 1_000_000  # [ns] that a message was published before it was logged


def write_foreign(
    path: Path,
    topics: Iterable[str] = ("/t",),
    message_encoding: str = "cdr",
    schema_encoding: str = "ros2msg",
) -> Path:
    """One std_msgs/String a topic, published a millisecond before it was logged."""
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="", library="another")
        schema = writer.register_schema("std_msgs/String", schema_encoding, b"string data")
        for topic in topics:
            channel = writer.register_channel(topic, message_encoding, schema)
            times = {"log_time": NOW, "publish_time": NOW - EARLIER}
            writer.add_message(channel, data=b"\1\0\0\0x", sequence=7, **times)
        writer.finish()
    return path
