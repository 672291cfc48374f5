# SPDX-License-Identifier: BSD-3-Clause
"""Whether a process of this host runs, is stopped or has ended, as the kernel says it.

A process that is stopped (SIGSTOP) appears to its peers like one that is slow. The kernel knows the
difference at once, and never takes a busy process for a stopped one.
"""

from __future__ import annotations

import contextlib
import os
import signal
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from rst_control.host.listening_sockets import PROC, inodes_of, listeners

ENDED: Final = "ended"
STOPPED: Final = "was stopped"
_STOPPED = ("T", "t")  # by a signal; by a debugger
_ENDED = ("Z", "X", "x")
# Fields of /proc/<pid>/task/<pid>/stat behind the name (proc(5)), and what is looked for in them
_STATE, _FLAGS, _START, _PENDING = 0, 6, 19, 28
_EXITING = 0x4  # PF_EXITING: it is being taken down, which takes long where it held much memory
_KILLED = 1 << (signal.SIGKILL - 1)  # sent, and not yet seen by it for want of a processor
_LONGEST = 4096  # bytes of that file


@dataclass(frozen=True)
class Process:
    """One process, and not a later one with the same number: its start time counts."""

    pid: int
    started: str  # clock ticks since the system came up

    def state(self, proc: Path = PROC) -> str:
        """What has become of it, in words; empty: it may run."""
        fields = _fields(self.pid, proc)
        if not fields or fields[_START] != self.started or _is_ending(fields):
            return ENDED
        return STOPPED if fields[_STATE] in _STOPPED else ""


def process_of(pid: int, port: int, proc: Path = PROC) -> Process | None:
    """The process that listens on a TCP port of this host; None where another does, or none.

    Args:
        pid: What the peer at that port says of itself; in another container it means nothing here.
        port: Where the peer is reached.
        proc: The kernel's files.
    """
    own = inodes_of(pid, proc)
    if not any(
        listener.port == port and listener.inode in own for listener in listeners(proc / "net")
    ):
        return None
    fields = _fields(pid, proc)
    return Process(pid, fields[_START]) if fields else None


def _is_ending(fields: list[str]) -> bool:
    """Whether it has ended, or nothing can keep it from doing so."""
    has_begun = bool(int(fields[_FLAGS]) & _EXITING or int(fields[_PENDING]) & _KILLED)
    return has_begun or fields[_STATE] in _ENDED


def _fields(pid: int, proc: Path) -> list[str]:
    """Of the first thread: for a whole process the kernel sums up all threads, which takes long."""
    raw = b""
    with contextlib.suppress(OSError):
        file = os.open(f"{proc}/{pid}/task/{pid}/stat", os.O_RDONLY | os.O_CLOEXEC)
        try:
            raw = os.read(file, _LONGEST)
        finally:
            os.close(file)
    text = raw.decode("ascii", "replace")
    fields = text.rpartition(")")[2].split()  # a name may hold spaces and brackets
    return fields if len(fields) > _PENDING else []
