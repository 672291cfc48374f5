# SPDX-License-Identifier: BSD-3-Clause
"""The share of a busy machine that a process gets: its own priority, and that of its session.

Linux weighs sessions first, then the processes of a session (sched(7), "autogroup"). roslaunch
starts each node in a session of its own, so a node's own priority alone changes nothing there.
"""

from __future__ import annotations

import os
import resource
from contextlib import suppress
from pathlib import Path
from typing import Final

AUTOGROUP: Final = Path("/proc/self/autogroup")
TERMINAL: Final = Path("/dev/tty")  # there only for a session that has one


def set_priority(nice: int) -> int:
    """Set the priority of this process, of the threads that it will make, and of its session.

    Call it before the first thread is made.

    Args:
        nice: From -20, which goes first, to 19.

    Returns:
        The one that it has now. Who is not root gets no more than limits.conf(5) grants as `nice`.
    """
    try:
        os.setpriority(os.PRIO_PROCESS, 0, nice)
    except PermissionError:
        nice = max(nice, min(_most_allowed(), os.getpriority(os.PRIO_PROCESS, 0)))
        os.setpriority(os.PRIO_PROCESS, 0, nice)
    weigh_session(nice)
    return nice


def weigh_session(nice: int, process: int | None = None) -> None:
    """Set the priority of a session.

    Args:
        nice: From -20, which goes first, to 19.
        process: One of the session; None: this session is meant, which stays as it is where a
            person works in it at a terminal.
    """
    if process is None and _has_terminal():
        return
    group = AUTOGROUP if process is None else Path(f"/proc/{process}/autogroup")
    with suppress(OSError):  # not allowed, or a kernel without groups of sessions
        group.write_text(str(nice), encoding="ascii")


def _most_allowed() -> int:
    limit = resource.getrlimit(resource.RLIMIT_NICE)[0]
    return -20 if limit == resource.RLIM_INFINITY else 20 - limit  # getrlimit(2)


def _has_terminal() -> bool:
    try:
        os.close(os.open(TERMINAL, os.O_RDONLY | os.O_NOCTTY))
    except OSError:
        return False
    return True
