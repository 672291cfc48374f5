# SPDX-License-Identifier: BSD-3-Clause
"""Shows what the alarm node reports, in the terminal or as lines."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import nullcontext
from typing import Protocol

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from rich.console import Console
from rich.live import Live

from typed_config.ros.starting import refuse_words
from voice_assist.alarms.appearance import line
from voice_assist.alarms.screen import NO_WORD, AlarmScreen
from voice_assist.alarms.types import AlarmText, Kind, Priority
from voice_assist.msg import Alarm as AlarmMessage
from voice_assist.ros.alarms.alarm_watch import AlarmWatch
from voice_assist.ros.believed import Believed
from voice_assist.ros.connected import is_connected, publisher_of

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

    def __init__(self, view: View, clock: Callable[[], float] = time.monotonic) -> None:
        self._view = view
        self._shown: AlarmMessage | str | None = "nothing yet"
        self._watch = AlarmWatch(self._show, lambda: is_connected(self._topic), clock)
        hear = Believed().hear
        self._topic = hear("system", "voice_assist/alarm", AlarmMessage, self._take)
        hear("system", "/diagnostics", DiagnosticArray, self._see_status)

    def look(self) -> None:
        """Notice that no alarm node is there, or it hangs: then nothing says that all is well."""
        self._watch.look_again()

    def _take(self, message: AlarmMessage) -> None:
        self._watch.see_alarm(message, publisher_of(message))

    def _see_status(self, message: DiagnosticArray) -> None:
        self._watch.see_status(publisher_of(message))

    def _show(self, message: AlarmMessage | None) -> None:
        if message is self._shown:
            return
        self._shown = message
        if message is None:
            self._view.lose()
        else:
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
    refuse_words(__doc__)
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
