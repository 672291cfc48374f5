# SPDX-License-Identifier: BSD-3-Clause
"""How bytes from the network become messages, and how long messages may be; without rospy."""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable
from typing import Final

LONGEST_MESSAGE: Final = 65_536  # bytes; the longest that our nodes wait for has some 600
LONGEST_HEADER: Final = 65_536  # bytes of a handshake; it holds the text of a message's definition
NEWS_PERIOD: Final = 5.0  # [s] between reports about refusals in one place
MAX_PLACES: Final = 64  # whose refusals are counted one by one

_SIZE = struct.Struct("<I")


def split_messages(data: bytes, most: int | None = None) -> tuple[list[bytes], bytes]:
    """Messages that are whole, without the lengths that lead them, and the bytes behind them.

    Args:
        data: What came over a connection: messages, each led by its length as uint32.
        most: How many of them to take at most; None: all.

    Returns:
        The whole messages, up to the first that is longer than LONGEST_MESSAGE; and all behind
        them, beginning with the length of the next message.
    """
    messages: list[bytes] = []
    start = 0
    while len(data) - start >= _SIZE.size and len(messages) != most:
        (size,) = _SIZE.unpack_from(data, start)
        end = start + _SIZE.size + size
        if size > LONGEST_MESSAGE or end > len(data):
            break
        messages.append(data[start + _SIZE.size : end])
        start = end
    return messages, data[start:]


def announced(data: bytes) -> int:
    """Length of the message that bytes begin with, as it was announced; 0 where it was not yet."""
    return int(_SIZE.unpack_from(data)[0]) if len(data) >= _SIZE.size else 0


def has_whole_header(data: bytes) -> bool | None:
    """Whether what a peer said first is a handshake of its announced length.

    Returns:
        True where it is there as a whole; False where it never will be, because the peer hung up
        or announces more than LONGEST_HEADER; None where more has to come.
    """
    if not data:
        return False
    if len(data) < _SIZE.size:
        return None
    (size,) = _SIZE.unpack_from(data)
    if not 0 < size <= LONGEST_HEADER:
        return False
    return True if len(data) >= _SIZE.size + size else None


class Refusals:
    """Counts what was refused, place by place, and reports it seldom enough; from any thread.

    Args:
        clock: Time [s].
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock, self._lock = clock, threading.Lock()
        self._unreported: dict[str, int] = {}
        self._reported: dict[str, float] = {}

    def count(self, where: str, words: str) -> str:
        """Count a refusal.

        Returns:
            What to report, with the number of those that were kept back; empty: nothing now.
        """
        with self._lock:
            if where not in self._reported and len(self._reported) >= MAX_PLACES:
                where = ""
            now = self._clock()
            if now - self._reported.get(where, float("-inf")) < NEWS_PERIOD:
                self._unreported[where] = self._unreported.get(where, 0) + 1
                return ""
            self._reported[where] = now
            kept_back = self._unreported.pop(where, 0)
            return f"{words}; and {kept_back} more before it" if kept_back else words
