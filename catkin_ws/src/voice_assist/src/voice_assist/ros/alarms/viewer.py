# SPDX-License-Identifier: BSD-3-Clause
"""Shows in the terminal what the alarm node tells."""

from __future__ import annotations

import time

import rospy
from rich.console import Console
from rich.live import Live

from voice_assist.alarms.screen import AlarmScreen
from voice_assist.alarms.types import AlarmText, Kind, Priority
from voice_assist.msg import Alarm as AlarmMessage

_REFRESH = 8  # [Hz], enough for flashing


def main() -> None:
    """Show alarms until Ctrl-C or the end of ROS."""
    rospy.init_node("alarm_viewer", anonymous=True)
    console, screen = Console(), AlarmScreen(time.time)
    rospy.Subscriber("voice_assist/alarm", AlarmMessage, lambda m: _take(screen, m))
    with Live(screen, console=console, refresh_per_second=_REFRESH):
        rospy.spin()


def _take(screen: AlarmScreen, message: AlarmMessage) -> None:
    screen.show(_alarm(message), message.acknowledged, tuple(message.others))


def _alarm(message: AlarmMessage) -> AlarmText | None:
    if not message.kind:
        return None
    kind, priority = Kind(message.kind), Priority(message.priority)
    return AlarmText(kind, priority, message.cause, message.next_step)
