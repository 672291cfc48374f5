# SPDX-License-Identifier: BSD-3-Clause
"""Separates recognition that hangs from recognition that waits for a processor.

How long a piece of work takes says little on a busy machine. The kernel counts for each thread how
long it wanted to run and could not. A virtual machine counts the time that its host took from each
processor. What is left of the time, the thread could have used: it ran, or waited for something
other than a processor.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Final

TASKS: Final = Path("/proc/self/task")
PROCESSORS: Final = Path("/proc/stat")
_NANO: Final = 1e-9
_LONGEST: Final = 4096  # bytes of a record
_STOLEN: Final = 8  # the word of a processor's line that counts what the host took [ticks]

Waits = Mapping[str, float]  # thread or processor and how long it has waited in its life [s]


def waits(tasks: Path = TASKS) -> dict[str, float]:
    """How long each thread of this process has waited for a processor [s].

    Empty where the kernel does not count: then all time counts as time that could have been used.
    """
    found = {}
    with suppress(OSError), os.scandir(tasks) as entries:
        for task in entries:
            with suppress(OSError, ValueError, IndexError):  # it has ended, or nothing is counted
                found[task.name] = int(_read(f"{task.path}/schedstat").split()[1]) * _NANO
    return found


def stolen(processors: Path = PROCESSORS) -> dict[str, float]:
    """How long the host of a virtual machine has used each processor for others [s].

    Empty where the kernel does not count.
    """
    found, tick = {}, 1.0 / os.sysconf("SC_CLK_TCK")
    with suppress(OSError, ValueError, IndexError):
        for line in processors.read_text(encoding="ascii").splitlines():
            words = line.split()
            if words[0].startswith("cpu") and words[0] != "cpu":
                found[words[0]] = int(words[_STOLEN]) * tick
    return found


class HangWatch:
    """Judges one piece of work after the other.

    A thread may wait for another one of the process, for Python's lock above all, and that one for
    a processor. So the time does not count in which any thread waited, the longest of them. Nor
    does what the host took from the processor that lost most.

    Args:
        allowed: Time that a piece of work may use [s].
        read: How long each thread has waited for a processor so far [s].
        read_stolen: How long each processor was the host's so far [s].
    """

    def __init__(
        self,
        allowed: float,
        read: Callable[[], Waits] = waits,
        read_stolen: Callable[[], Waits] = stolen,
    ) -> None:
        self._allowed, self._sources = allowed, (read, read_stolen)
        self._since: float | None = None
        self._first, self._before = 0.0, tuple[Waits, ...]()

    def used(self, since: float | None, now: float) -> float:
        """Time that the present piece of work has had at least [s].

        Args:
            since: When it was begun, steady clock [s]; None: there is none.
            now: Present time, that clock [s].
        """
        if since is None:
            self._since = None
            return 0.0
        if since != self._since:  # most work is over before the next call: it is not read for
            self._since, self._before = since, ()
            return 0.0
        if not self._before:
            self._first, self._before = now, tuple(dict(read()) for read in self._sources)
            return 0.0
        if now - self._first <= self._allowed:
            return now - self._first  # at most
        pairs = zip(self._before, self._sources, strict=True)
        return now - self._first - sum(_longest(before, read()) for before, read in pairs)

    def objection(self, since: float | None, now: float) -> str:
        """Why it counts as hanging; empty: it does not."""
        used = self.used(since, now)
        if used <= self._allowed:
            return ""
        return f"recognition hangs: {used:.2f} s on one frame, allowed {self._allowed:g} s"


def _read(path: str) -> bytes:
    """A small file of the kernel; in a quarter of the time of pathlib, some 40 times a frame."""
    file = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        return os.read(file, _LONGEST)
    finally:
        os.close(file)


def _longest(before: Waits, after: Waits) -> float:
    return max((wait - before.get(name, wait) for name, wait in after.items()), default=0.0)
