# SPDX-License-Identifier: BSD-3-Clause
"""Ctrl-C while a node starts."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

import rospy


@contextmanager
def ends_on_interrupt() -> Iterator[None]:
    """While a node starts, SIGINT ends it at once.

    rospy's own handler lets the start go on to its end, which is long where kernels have to be
    compiled. A signal while the start speaks to the master can still hang, as both need one lock.
    """
    by_rospy = signal.signal(signal.SIGINT, _end)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, by_rospy)


def _end(number: int, _: FrameType | None) -> None:
    rospy.signal_shutdown("interrupted while it starts")
    sys.exit(128 + number)
