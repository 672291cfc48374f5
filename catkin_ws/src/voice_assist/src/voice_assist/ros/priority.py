# SPDX-License-Identifier: BSD-3-Clause
"""Asks the system to hear before it draws, logs or records."""

from __future__ import annotations

from typing import Final

from typed_config.priority import set_priority

NICE: Final = -20


def hear_first() -> str:
    """Give this process, and the threads it will make, more of a busy machine than others get.

    On two busy cores a "stop" else waits its turn behind the recorder and the pictures. Not in real
    time: an endless utterance would then keep the rest of the system from running. Call it before
    the first thread is made.

    Returns:
        What was granted, in words.
    """
    granted = set_priority(NICE)
    return f"nice {granted}" if granted < 0 else "none"
