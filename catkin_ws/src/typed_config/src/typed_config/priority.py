# SPDX-License-Identifier: BSD-3-Clause
"""The share of a busy machine that a process gets: its own priority, and that of its session.

Linux weighs sessions first, then the processes of a session (sched(7), "autogroup"). roslaunch
starts each node in a session of its own, so a node's own priority alone changes nothing there.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Final

AUTOGROUP: Final = Path("/proc/self/autogroup")
TERMINAL: Final = Path("/dev/tty")  # there only for a session that has one


def set_priority(nice: int) -> bool:
    """Set the priority of this process, of the threads that it will make, and of its session.

    Call it before the first thread is made.

    Args:
        nice: From -20, which goes first, to 19.

    Returns:
        Whether it was granted; only root may ask for more than others get.
    """
    try:
        os.setpriority(os.PRIO_PROCESS, 0, nice)
    except PermissionError:
        return False
    weigh_session(nice)
    return True


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


def _has_terminal() -> bool:
    try:
        os.close(os.open(TERMINAL, os.O_RDONLY | os.O_NOCTTY))
    except OSError:
        return False
    return True
