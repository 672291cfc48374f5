# SPDX-License-Identifier: BSD-3-Clause
"""The start of a node: how a signal ends it, and that it has the time of ROS."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

import rospy

CLOCK_PERIOD = 0.05  # [s] between two looks for the clock
CLOCK_DUE = 1.0  # [s] after which a missing one is named
CLOCK_AGAIN = 10.0  # [s] after which it is named again


@contextmanager
def starting(name: str, needs_clock: bool = True) -> Iterator[None]:
    """Begin a node of a name; what is done within is its start.

    SIGINT and SIGTERM end a node at once while it starts. rospy's own handlers take the node off
    the master within the code that they interrupt. They wait for ever where that code speaks to the
    master: both need the same lock. So they come with the end of the start; before it, rospy takes
    the node off the master at the exit.

    Args:
        name: Of the node.
        needs_clock: Where the time is simulated, the start waits for /clock.
    """
    received: list[int] = []

    def end(number: int, _: FrameType | None) -> NoReturn:
        received.append(number)
        signal.signal(number, signal.SIG_IGN)  # roslaunch and `respawn` both send it
        sys.exit(128 + number)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    rospy.init_node(name, disable_signals=True)
    if needs_clock:
        wait_for_clock()
    yield
    rospy.core.register_signals()
    rospy.core._signalChain.clear()  # those before them, which they would call, too
    if received:  # the interrupted code went on, as a destructor or a bare `except` does
        sys.exit(128 + received[0])


def wait_for_clock() -> None:
    """Where `use_sim_time` is true, wait for the first time on /clock, and say so.

    Until then the time is zero: no stamp and no age would be true.
    """
    named_at = time.monotonic() + CLOCK_DUE
    while rospy.get_time() == 0.0 and not rospy.is_shutdown():
        if time.monotonic() >= named_at:
            named_at = time.monotonic() + CLOCK_AGAIN
            rospy.logerr(
                "use_sim_time is true and nobody publishes /clock: this node waits for it. On real "
                "hardware end the launch, and say: rosparam delete /use_sim_time"
            )
        time.sleep(CLOCK_PERIOD)
