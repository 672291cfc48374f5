# SPDX-License-Identifier: BSD-3-Clause
"""Reads the std_msgs/Header at the front of a serialised message without decoding the rest."""

from __future__ import annotations

import struct
from typing import NamedTuple

_LAYOUT = struct.Struct("<III")  # seq, stamp.secs, stamp.nsecs


class HeaderStamp(NamedTuple):
    """The numbers of a std_msgs/Header."""

    sequence: int  # set by the publisher's client library, one more each message
    stamp: int  # [ns] since 1970


def starts_with_header(definition: str) -> bool:
    """Whether the first field of a message definition is a std_msgs/Header."""
    for line in definition.splitlines():
        words = line.split("#", 1)[0].split()
        if not words or "=" in line.split("#", 1)[0]:
            continue  # empty, comment or constant
        return words[0] in ("Header", "std_msgs/Header")
    return False


def read_header(data: bytes) -> HeaderStamp | None:
    """Take sequence and stamp from a message that starts with a header; None if it is too short."""
    if len(data) < _LAYOUT.size:
        return None
    sequence, secs, nsecs = _LAYOUT.unpack_from(data)
    return HeaderStamp(sequence, secs * 1_000_000_000 + nsecs)
