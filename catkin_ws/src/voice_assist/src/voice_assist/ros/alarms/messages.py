# SPDX-License-Identifier: BSD-3-Clause
"""Messages that alarms are made from, and the messages that they become."""

from __future__ import annotations

import math
from collections.abc import Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from rst_control.msg import ControllerState, Event
from voice_assist.alarms.appearance import APPEARANCES, line
from voice_assist.alarms.board import Standing
from voice_assist.alarms.types import (
    AlarmText,
    ControllerEvent,
    PartHealth,
    RobotState,
    UtteranceReport,
)
from voice_assist.config.alarms import AlarmMarkerConfig
from voice_assist.msg import Alarm as AlarmMessage
from voice_assist.msg import Utterance as UtteranceMessage
from voice_assist.ros.messages import is_bad

MARKER, HEARD = "alarm", "heard"  # name spaces of the markers
BELOW = 4.0  # heights of a letter from the alarm's line to what is heard
HEARD_TAKEN, HEARD_OTHERWISE = (0.35, 0.8, 0.45, 1.0), (0.85, 0.85, 0.85, 1.0)  # RGBA


def robot_state(message: ControllerState) -> RobotState:
    """What the controller says of itself."""
    return RobotState(
        stamp=message.header.stamp.to_sec(),
        state=message.state,
        halt_reason=message.halt_reason,
        halt_reason_code=message.halt_reason_code,
        is_active=message.assistance_enabled,
        is_tissue_held=message.tissue_held,
    )


def controller_event(message: Event) -> ControllerEvent:
    """An entry of the controller's event log."""
    return ControllerEvent(message.kind, message.command, message.message, message.reason_code)


def utterance(message: UtteranceMessage) -> UtteranceReport:
    """A decision of the recogniser."""
    wer = dict(zip(message.phrases, message.wer, strict=False))
    nearest, code = message.nearest_command, message.reason_code
    wer_to_nearest = wer.get(nearest, math.inf)
    return UtteranceReport(message.command, message.reason, code, nearest, wer_to_nearest)


def part_health(status: DiagnosticStatus) -> PartHealth:
    """One status of `/diagnostics`."""
    code = next((pair.value for pair in status.values if pair.key == "reason_code"), "")
    return PartHealth(status.name, is_bad(status), status.message, code)


def alarm_message(standing: Sequence[Standing], now: float, stamp: float) -> AlarmMessage:
    """What comes first, with all else that stands.

    Args:
        standing: What comes first in front; empty: all is well.
        now: By the clock of what stands [s].
        stamp: The same by the clock of messages [s].
    """
    message = AlarmMessage()
    message.header.stamp = rospy.Time.from_sec(stamp)
    if not standing:
        return message
    first = standing[0]
    message.kind, message.priority = first.alarm.kind.value, int(first.alarm.priority)
    message.cause, message.next_step = first.alarm.cause, first.alarm.next_step
    message.since = rospy.Time.from_sec(max(stamp - (now - first.since), 0.0))
    message.acknowledged = first.is_acknowledged
    message.others = [line(entry.alarm) for entry in standing[1:]]
    return message


def heard_words(message: UtteranceMessage) -> str:
    """What was heard and what it was taken for, or why not, in two lines."""
    result = f"-> {message.command}" if message.command else f"not taken: {message.reason}"
    return f'heard "{message.transcript.strip()}"\n{result}'


def heard_marker(
    words: str, is_taken: bool, config: AlarmMarkerConfig, shown_for: float, now: float
) -> Marker:
    """What is heard, as text for rviz and Foxglove below the alarm; it goes by itself.

    Args:
        words: To be shown.
        is_taken: A command was taken.
        config: Frame, place and size of the alarm's line.
        shown_for: How long it stays [s].
        now: Stamp [s].
    """
    marker = Marker(ns=HEARD, id=0, type=Marker.TEXT_VIEW_FACING, action=Marker.ADD, text=words)
    marker.header.stamp, marker.header.frame_id = rospy.Time.from_sec(now), config.frame
    marker.lifetime = rospy.Duration.from_sec(shown_for)
    marker.pose.orientation.w = 1.0
    x, y, z = config.place
    marker.pose.position, marker.scale.z = Point(x, y, z - BELOW * config.letter), config.letter
    marker.color = ColorRGBA(*(HEARD_TAKEN if is_taken else HEARD_OTHERWISE))
    return marker


def alarm_marker(
    alarm: AlarmText | None, is_lit: bool, config: AlarmMarkerConfig, now: float
) -> Marker:
    """The line for rviz and Foxglove; dim in the dark half of its flashing.

    Args:
        alarm: What comes first; None: the line goes.
        is_lit: It is in the bright half.
        config: Frame, place and size.
        now: Stamp [s].
    """
    marker = Marker(ns=MARKER, id=0, type=Marker.TEXT_VIEW_FACING, action=Marker.DELETE)
    marker.header.stamp, marker.header.frame_id = rospy.Time.from_sec(now), config.frame
    marker.pose.orientation.w = 1.0
    if alarm is None:
        return marker
    red, green, blue, opacity = APPEARANCES[alarm.priority].rgba
    marker.action, marker.text = Marker.ADD, line(alarm).replace(" -> ", "\n")
    marker.color = ColorRGBA(red, green, blue, opacity if is_lit else 0.35 * opacity)
    marker.pose.position, marker.scale.z = Point(*config.place), config.letter
    return marker
