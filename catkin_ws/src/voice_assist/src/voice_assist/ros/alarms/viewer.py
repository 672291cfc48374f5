# SPDX-License-Identifier: BSD-3-Clause
"""Shows what the alarm node reports, in the terminal or as lines."""

from __future__ import annotations

import threading
import time
from contextlib import nullcontext
from typing import Protocol

import rospy
from rich.console import Console
from rich.live import Live

from voice_assist.alarms.appearance import line
from voice_assist.alarms.screen import NO_WORD, AlarmScreen
from voice_assist.alarms.types import AlarmText, Kind, Priority
from voice_assist.msg import Alarm as AlarmMessage
from voice_assist.ros.connected import is_connected

_REFRESH = 8  # [Hz], enough for flashing
_LOOK_AGAIN = 0.2  # [s] between looks whether the alarm node is there


class View(Protocol):
    """Shows what the alarm node reports."""

    def show(self, alarm: AlarmText | None, is_acknowledged: bool, others: tuple[str, ...]) -> None:
        """Show what stands now."""
        ...

    def lose(self) -> None:
        """Show that nothing is known."""
        ...


class Viewer:
    """Follows the alarm node.

    Args:
        view: Shows what it reports, and that it is not there.
    """

    def __init__(self, view: View) -> None:
        self._view, self._is_lost = view, False
        self._lock = threading.Lock()  # or a loss could be shown after the word of a new node
        self._topic = rospy.Subscriber("voice_assist/alarm", AlarmMessage, self._take)

    def look(self) -> None:
        """Notice that no alarm node is there: then nothing says whether all is well."""
        with self._lock:
            if not self._is_lost and not is_connected(self._topic):
                self._is_lost = True
                self._view.lose()

    def _take(self, message: AlarmMessage) -> None:
        with self._lock:
            self._is_lost = False
            self._view.show(_alarm(message), message.acknowledged, tuple(message.others))


class Lines:
    """A line for each report, where there is no terminal."""

    def show(self, alarm: AlarmText | None, _: bool, others: tuple[str, ...]) -> None:
        """Print what stands now."""
        print("; ".join([line(alarm) if alarm else "no alarm", *others]), flush=True)

    def lose(self) -> None:
        """Print that nothing is known."""
        print(NO_WORD, flush=True)


def main() -> None:
    """Show alarms until Ctrl-C or the end of ROS."""
    rospy.init_node("alarm_viewer", anonymous=True)
    console, screen = Console(), AlarmScreen(time.time)
    viewer = Viewer(screen if console.is_terminal else Lines())
    live = Live(screen, console=console, refresh_per_second=_REFRESH)
    with live if console.is_terminal else nullcontext():
        while not rospy.is_shutdown():
            viewer.look()
            rospy.rostime.wallsleep(_LOOK_AGAIN)


def _alarm(message: AlarmMessage) -> AlarmText | None:
    if not message.kind:
        return None
    kind, priority = Kind(message.kind), Priority(message.priority)
    return AlarmText(kind, priority, message.cause, message.next_step)
