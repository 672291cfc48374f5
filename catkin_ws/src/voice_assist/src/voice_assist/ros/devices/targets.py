# SPDX-License-Identifier: BSD-3-Clause
"""Services, topics and actions of any type, by name; each call ends within its time."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from queue import Empty, Queue
from typing import Any, Final, Protocol

import genpy
import rospy
from actionlib import GoalIDGenerator
from actionlib_msgs.msg import GoalID, GoalStatus
from genpy.message import fill_message_args

from voice_assist.config.devices import DeviceCallConfig
from voice_assist.devices.calls import CallResult
from voice_assist.errors import CommandsError
from voice_assist.ros.devices.types import message_class, service_class
from voice_assist.ros.service_calls import call_service

ANSWER_FIELDS: Final = ("success", "accepted")  # of a response that may say no
MAY_COME: Final = "; it may still be carried out"  # a request that was sent and not answered


class Target(Protocol):
    """What is called."""

    def call(self) -> CallResult:
        """Call it; returns within the time of its settings."""
        ...


def make_target(config: DeviceCallConfig) -> Target:
    """What a call of the settings goes to.

    Raises:
        CommandsError: There is no such type, or the arguments do not fit it.
    """
    try:
        return _KINDS[config.kind](config)
    except genpy.MessageException as error:
        words = f"arguments that fit {config.type}: {error}"
        raise CommandsError("arguments", config.arguments, words) from None


def _filled(kind: type, values: dict[str, Any]) -> Any:
    message = kind()
    fill_message_args(message, [values] if values else [])
    message._check_types()
    return message


class _Service:
    def __init__(self, config: DeviceCallConfig) -> None:
        self._config = config
        self._kind = service_class(config.type)
        self._request = _filled(self._kind._request_class, config.values)

    def call(self) -> CallResult:
        config, request = self._config, self._request
        words = [getattr(request, field) for field in request.__slots__]
        reply = call_service(config.target, self._kind, *words, within=config.within)
        if (response := reply.response) is None:
            trouble = reply.trouble + (MAY_COME if reply.may_take_effect else "")
            return CallResult(config, False, trouble)
        says = [getattr(response, name) for name in ANSWER_FIELDS if hasattr(response, name)]
        return CallResult(config, all(says), str(getattr(response, "message", "")))


class _Topic:
    def __init__(self, config: DeviceCallConfig) -> None:
        self._config = config
        kind = message_class(config.type)
        self._message = _filled(kind, config.values)
        self._topic = _publisher(config.target, kind)

    def call(self) -> CallResult:
        if not _wait(lambda: self._topic.get_num_connections() > 0, self._config.within):
            return CallResult(self._config, False, f"nobody listens to {self._config.target}")
        self._topic.publish(self._message)
        return CallResult(self._config, True, "sent")


class _Action:
    """A goal, its result, and its end where it takes too long; by the topics of actionlib."""

    def __init__(self, config: DeviceCallConfig) -> None:
        self._config = config
        self._new_id = GoalIDGenerator().generate_ID  # unlike those of an earlier process
        self._results: Queue[Any] = Queue()
        goal = message_class(f"{config.type}ActionGoal")
        self._goal = goal(goal=_filled(type(goal().goal), config.values))
        self._topic = _publisher(f"{config.target}/goal", goal)
        self._cancel = _publisher(f"{config.target}/cancel", GoalID)
        rospy.Subscriber(
            f"{config.target}/result",
            message_class(f"{config.type}ActionResult"),
            self._results.put,
            queue_size=10,
        )

    def call(self) -> CallResult:
        end = time.monotonic() + self._config.within
        if not _wait(lambda: self._topic.get_num_connections() > 0, self._config.within):
            return CallResult(self._config, False, f"nobody serves {self._config.target}")
        goal_id = self._goal.goal_id = self._new_id()
        self._goal.header.stamp = goal_id.stamp
        self._topic.publish(self._goal)
        while (left := end - time.monotonic()) > 0.0:
            try:
                result = self._results.get(timeout=left)
            except Empty:
                break
            if result.status.goal_id.id == goal_id.id:
                is_done = result.status.status == GoalStatus.SUCCEEDED
                return CallResult(self._config, is_done, result.status.text)
        self._cancel.publish(goal_id)
        words = f"no result within {self._config.within:g} s; cancelled"
        return CallResult(self._config, False, words)


_KINDS: Mapping[str, Callable[[DeviceCallConfig], Target]] = {
    "service": _Service,
    "topic": _Topic,
    "action": _Action,
}
_publishers: dict[tuple[str, type], rospy.Publisher] = {}


def _publisher(target: str, kind: type) -> rospy.Publisher:
    """One for each topic, however many calls go to it."""
    if (target, kind) not in _publishers:
        _publishers[target, kind] = rospy.Publisher(target, kind, queue_size=10)
    return _publishers[target, kind]


def _wait(is_there: Callable[[], bool], within: float) -> bool:
    end = time.monotonic() + within
    while not is_there():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True
