# SPDX-License-Identifier: BSD-3-Clause
"""Shows what the alarm node reports, in the terminal or as lines."""

from __future__ import annotations

import time
from contextlib import nullcontext
from functools import partial

import rospy
from rich.console import Console
from rich.live import Live

from voice_assist.alarms.appearance import line
from voice_assist.alarms.screen import AlarmScreen
from voice_assist.alarms.types import AlarmText, Kind, Priority
from voice_assist.msg import Alarm as AlarmMessage

_REFRESH = 8  # [Hz], enough for flashing


def main() -> None:
    """Show alarms until Ctrl-C or the end of ROS."""
    rospy.init_node("alarm_viewer", anonymous=True)
    console, screen = Console(), AlarmScreen(time.time)
    take = partial(_take, screen) if console.is_terminal else _print
    rospy.Subscriber("voice_assist/alarm", AlarmMessage, take)
    live = Live(screen, console=console, refresh_per_second=_REFRESH)
    with live if console.is_terminal else nullcontext():
        rospy.spin()


def _take(screen: AlarmScreen, message: AlarmMessage) -> None:
    screen.show(_alarm(message), message.acknowledged, tuple(message.others))


def _print(message: AlarmMessage) -> None:
    alarm = _alarm(message)
    print("; ".join([line(alarm) if alarm else "no alarm", *message.others]), flush=True)


def _alarm(message: AlarmMessage) -> AlarmText | None:
    if not message.kind:
        return None
    kind, priority = Kind(message.kind), Priority(message.priority)
    return AlarmText(kind, priority, message.cause, message.next_step)
