# SPDX-License-Identifier: BSD-3-Clause
"""Lets a request to end (SIGTERM), and a terminal that closes (SIGHUP), end as Ctrl-C does.

Without it the process would be gone at once, and what it started would run on: a robot, too.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

REQUESTS = (signal.SIGTERM, signal.SIGHUP)


def end_as_by_ctrl_c() -> None:
    """From now on the first such signal raises KeyboardInterrupt; later ones change nothing."""
    for request in REQUESTS:
        if signal.getsignal(request) is not signal.SIG_IGN:  # as under nohup
            signal.signal(request, _interrupt)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Ctrl-C does nothing in here: what ends others must itself come to its end.

    In the main thread; in others it does nothing anyway.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _interrupt(number: int, frame: object) -> None:
    for request in REQUESTS:
        signal.signal(request, signal.SIG_IGN)
    raise KeyboardInterrupt
