# SPDX-License-Identifier: BSD-3-Clause
"""Asks the system to hear before it draws, logs or records."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

AUTOGROUP = Path("/proc/self/autogroup")  # Linux weighs sessions first, then processes in them
NICE = -10


def hear_first() -> str:
    """Give this process, and the threads it will make, more of a busy machine than others get.

    On two busy cores a "stop" else waits its turn behind the recorder and the pictures. Not in real
    time: an endless utterance would then keep the rest of the system from running. Call it before
    the first thread is made.

    Returns:
        What was granted, in words.
    """
    try:
        os.setpriority(os.PRIO_PROCESS, 0, NICE)
    except PermissionError:  # not root, and no right to it in limits.conf
        return "none"
    with suppress(OSError):  # a kernel without groups of sessions
        AUTOGROUP.write_text(str(NICE), encoding="ascii")
    return f"nice {NICE}"
