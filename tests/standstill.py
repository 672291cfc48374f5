# SPDX-License-Identifier: BSD-3-Clause
"""Whether the machine kept up during a test with running nodes, or the test fell to its load.

A robot that holds since its set-points came late does as it must, so a rostest that failed by it
shows something of the machine and nothing of the wiring it is about.
"""

from __future__ import annotations

import re
import threading
import time
from types import TracebackType

LONG = 0.05  # [s] of a standstill that the watchdogs of a robot in motion take for a loss
_EVERY = 0.005  # [s]
_OVERTAKEN = re.compile(  # the halts that lateness alone brings about; the last two follow from it
    r"set-points stopped coming while moving, \d+ ms ago"
    r"|joint states stale, \d+ ms old"
    r"|bridge did not run for [\d.]+ s in motion"
    r"|joints of (?:the arm|OpenRST) \d+ ms old"
    r"|the stop guard is silent for [\d.]+ s"
    r"|[+-][\d.]+ rad off its (?:set-point|course)"
    r"|shaft [\d.]+ mm off the trocar"
)


class Standstills:
    """In a `with` block: the longest time in which a thread that only sleeps did not run."""

    def __init__(self, ended: threading.Event | None = None) -> None:
        self.longest = 0.0  # [s]
        self._ended = ended or threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> Standstills:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        self._thread.join()

    def _watch(self) -> None:
        last = time.monotonic()
        while not self._ended.wait(_EVERY):
            now = time.monotonic()
            self.longest = max(self.longest, now - last - _EVERY)
            last = now


def overtaken(printed: str, longest: float) -> str:
    """What shows that a test may have failed by the load of the machine alone.

    Args:
        printed: What the test and its nodes printed.
        longest: Longest standstill of the machine meanwhile [s].

    Returns:
        The evidence in words; empty where there is none.
    """
    found = _OVERTAKEN.search(printed)
    if found:
        return found[0]
    return f"the machine stood still for {longest * 1e3:.0f} ms" if longest >= LONG else ""
