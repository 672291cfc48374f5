# SPDX-License-Identifier: BSD-3-Clause
"""How a node ends while it starts."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn


@contextmanager
def ends_on_signal(afterwards: Callable[[], None]) -> Iterator[None]:
    """While a node starts, SIGINT and SIGTERM end it at once.

    rospy's own handlers take the node off the master within the code that they interrupt. They wait
    for ever where that code speaks to the master: both need the same lock. So `rospy.init_node` is
    called within, with `disable_signals=True`; rospy takes the node off the master at its exit.

    Args:
        afterwards: Sets the handlers of the node that has started.
    """
    received: list[int] = []

    def end(number: int, _: FrameType | None) -> NoReturn:
        received.append(number)
        sys.exit(128 + number)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)  # rospy's call those before them
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        afterwards()
    if received:  # the interrupted code went on, as a destructor or a bare `except` does
        sys.exit(128 + received[0])
