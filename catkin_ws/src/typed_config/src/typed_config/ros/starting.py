# SPDX-License-Identifier: BSD-3-Clause
"""The start of a node: its command line, what ends it, and that it has the time of ROS."""

from __future__ import annotations

import argparse
import atexit
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

import rospy

from typed_config.errors import ConfigError
from typed_config.ros.terminal import write_beside

WRONG = 2  # status of what cannot be started as it was asked for; `respawn` goes by it
SIGNALS = (signal.SIGINT, signal.SIGTERM)
END_AGAIN = 0.5  # [s] after which a node that still starts is ended again
END_LIMIT = 10.0  # [s] at the exit for what the shutdown has still to do
CLOCK_PERIOD = 0.05  # [s] between two looks for the clock
CLOCK_DUE = 1.0  # [s] after which a missing one is named
CLOCK_AGAIN = 10.0  # [s] after which it is named again


@contextmanager
def starting(
    name: str,
    about: str | None,
    needs_clock: bool = True,
    refusals: tuple[type[Exception], ...] = (ConfigError,),
    launch: str = "",
) -> Iterator[None]:
    """Begin a node of a name; what is done within is its start.

    What it logs keeps nobody waiting. An error that says why it cannot start is logged, and ends
    the process with status WRONG.

    SIGINT and SIGTERM end a node at once while it starts, and rospy takes it off the master at the
    exit. Code that swallows the exit, as a destructor does, gets it again. Afterwards signals shut
    the node down from a thread of its own.

    Args:
        name: Of the node.
        about: What it is, for `--help`; no other word of the command line is taken.
        needs_clock: Where the time is simulated, the start waits for /clock.
        refusals: Kinds of such errors.
        launch: File that starts the node with all that it needs; named beside the error.
    """
    refuse_words(about, launch)
    received: list[int] = []

    def end(number: int, _: FrameType | None) -> NoReturn:
        if number in SIGNALS:
            received.append(number)
            signal.signal(number, signal.SIG_IGN)  # roslaunch and `respawn` both send it
            signal.setitimer(signal.ITIMER_REAL, END_AGAIN, END_AGAIN)
        sys.exit(128 + received[0])

    for number in (*SIGNALS, signal.SIGALRM):
        signal.signal(number, end)
    try:
        rospy.init_node(name, disable_signals=True)
        write_beside()
        if needs_clock:
            wait_for_clock()
        yield
    except refusals as error:
        advice = f"; launch/{launch} starts it" if launch else ""
        rospy.logfatal("%s cannot start: %s%s", name, error, advice)
        sys.exit(WRONG)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    _shut_down_on_signals()
    if received:
        sys.exit(128 + received[0])


def refuse_words(about: str | None, launch: str = "") -> None:
    """End the process where its command line has words, but for remappings; `--help` explains it.

    Call it before rospy.init_node: the master ends a node that runs under the same name.

    Args:
        about: What the node is.
        launch: File that starts the node with all that it needs.
    """
    parser = argparse.ArgumentParser(
        usage="%(prog)s [-h] [name:=value ...]",
        description=about,
        epilog=f"launch/{launch} starts it with all that it needs" if launch else None,
    )
    parser.parse_args(rospy.myargv(sys.argv)[1:])


def _shut_down_on_signals() -> None:
    """Let SIGINT and SIGTERM shut the node down, beside the code that they interrupt.

    rospy's own handlers do it within that code. They wait for ever where it holds a lock that the
    shutdown needs, as that of the master, or where a thread that they join needs it.
    """
    reading, writing = os.pipe()
    is_asked, is_over = threading.Event(), threading.Event()

    def ask(number: int, _: FrameType | None) -> None:
        os.write(writing, bytes([number]))

    def shut_down() -> None:
        number = os.read(reading, 1)[0]
        is_asked.set()
        rospy.on_shutdown(_end_loops)  # after what the node itself does at its end
        rospy.core.signal_shutdown(f"signal-{number}")
        is_over.set()

    def finish() -> None:
        if is_asked.is_set():
            is_over.wait(END_LIMIT)

    threading.Thread(target=shut_down, name="ending", daemon=True).start()
    atexit.register(finish)
    for number in SIGNALS:
        signal.signal(number, ask)


def _end_loops() -> None:
    """Let `rospy.is_shutdown` hold before rospy closes the topics, not only afterwards.

    A loop that publishes between the two would end with an error.
    """
    rospy.core._shutdown_flag = True


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
