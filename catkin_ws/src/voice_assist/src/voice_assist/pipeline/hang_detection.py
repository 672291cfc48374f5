# SPDX-License-Identifier: BSD-3-Clause
"""Separates recognition that hangs from recognition that waits for a processor.

How long a piece of work takes says little on a busy machine. The kernel counts for each thread how
long it wanted to run and could not. What is left of the time, the thread could have used: it ran,
or waited for something other than a processor.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Final

TASKS: Final = Path("/proc/self/task")
_NANO: Final = 1e-9

Waits = Mapping[str, float]  # thread and how long it has waited for a processor in its life [s]


def waits(tasks: Path = TASKS) -> dict[str, float]:
    """How long each thread of this process has waited for a processor [s].

    Empty where the kernel does not count: then all time counts as time that could have been used.
    """
    found = {}
    with suppress(OSError):
        for task in tasks.iterdir():
            with suppress(OSError, ValueError, IndexError):  # it has ended, or nothing is counted
                words = (task / "schedstat").read_text(encoding="ascii").split()
                found[task.name] = int(words[1]) * _NANO
    return found


class HangWatch:
    """Judges one piece of work after the other.

    A thread may wait for another one of the process, for Python's lock above all, and that one for
    a processor. So the time does not count in which any thread waited, the longest of them.

    Args:
        allowed: Time that a piece of work may use [s].
        read: How long each thread has waited for a processor so far [s].
    """

    def __init__(self, allowed: float, read: Callable[[], Waits] = waits) -> None:
        self._allowed, self._read = allowed, read
        self._since: float | None = None
        self._first, self._before = 0.0, dict[str, float]()

    def used(self, since: float | None, now: float) -> float:
        """Time that the present piece of work has had at least [s].

        Args:
            since: When it was begun, steady clock [s]; None: there is none.
            now: Present time, that clock [s].
        """
        if since is None:
            self._since = None
            return 0.0
        if since != self._since:
            self._since, self._first, self._before = since, now, dict(self._read())
            return 0.0
        if now - self._first <= self._allowed:
            return now - self._first  # at most
        waited = [wait - self._before.get(task, wait) for task, wait in self._read().items()]
        return now - self._first - max(waited, default=0.0)

    def objection(self, since: float | None, now: float) -> str:
        """Why it counts as hanging; empty: it does not."""
        used = self.used(since, now)
        if used <= self._allowed:
            return ""
        return f"recognition hangs: {used:.2f} s on one frame, allowed {self._allowed:g} s"
