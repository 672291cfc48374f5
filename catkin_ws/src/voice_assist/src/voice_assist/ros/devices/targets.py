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

from typed_config.ros.connections import open_listeners
from typed_config.ros.service_calls import call_service, never
from typed_config.ros.system_names import of_this_system
from voice_assist.config.devices import DeviceCallConfig
from voice_assist.devices.calls import DROPPED, CallResult
from voice_assist.errors import CommandsError
from voice_assist.ros.devices.types import message_class, service_class

ANSWER_FIELDS: Final = ("success", "accepted")  # of a response that may say no
MAY_COME: Final = "; it may still be carried out"  # a request that was sent and not answered
NOT_BEGUN: Final = (GoalStatus.REJECTED, GoalStatus.RECALLED)  # goals without any effect
STEP: Final = 0.05  # [s] between looks whether a stop came
CANCEL_WITHIN: Final = 2.0  # [s] for a device to listen, where an action of before is cancelled
OBSERVERS: Final = ("/recorder", "/foxglove")  # nodes that listen to every topic: no device


class Target(Protocol):
    """What is called."""

    def call(self, is_stopped: Callable[[], bool] = never) -> CallResult:
        """Call it; returns within the time of its settings.

        Args:
            is_stopped: Whether a stop came: then nothing is sent, and an action is cancelled.
        """
        ...


def make_target(
    config: DeviceCallConfig, keep_goal: Callable[[str], None] = lambda _: None
) -> Target:
    """What a call of the settings goes to.

    Args:
        config: The call.
        keep_goal: Is given the id of an action's goal before it is sent, and "" when it has ended.

    Raises:
        CommandsError: There is no such type, or the arguments do not fit it.
    """
    try:
        if config.kind == "action":
            return _Action(config, keep_goal)
        return _KINDS[config.kind](config)
    except genpy.MessageException as error:
        words = f"arguments that fit {config.type}: {error}"
        raise CommandsError("arguments", config.arguments, words) from None


def cancel_left(config: DeviceCallConfig, goal_id: str) -> CallResult:
    """Cancel a goal of an earlier process, once its device listens."""
    topic = _publisher(f"{config.target}/cancel", GoalID)
    is_heard = _wait(topic, CANCEL_WITHIN, never)
    if is_heard:
        topic.publish(GoalID(id=goal_id))
    end = "cancelled" if is_heard else f"nobody serves {config.target} to cancel it"
    return CallResult(config, False, f"the devices node ended meanwhile; {end}")


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

    def call(self, is_stopped: Callable[[], bool] = never) -> CallResult:
        config, request = self._config, self._request
        words = [getattr(request, field) for field in request.__slots__]
        reply = call_service(
            config.target, self._kind, *words, within=config.within, is_void=is_stopped
        )
        if (response := reply.response) is None:
            trouble = reply.trouble + (MAY_COME if reply.may_take_effect else "")
            return CallResult(config, False, trouble, reply.may_take_effect)
        says = [getattr(response, name) for name in ANSWER_FIELDS if hasattr(response, name)]
        message = str(getattr(response, "message", ""))
        return CallResult(config, all(says), message, may_have_effect=all(says))


class _Topic:
    def __init__(self, config: DeviceCallConfig) -> None:
        self._config = config
        kind = message_class(config.type)
        self._message = _filled(kind, config.values)
        self._topic = _publisher(config.target, kind)

    def call(self, is_stopped: Callable[[], bool] = never) -> CallResult:
        if not _wait(self._topic, self._config.within, is_stopped):
            nobody = f"nobody listens to {self._config.target}"
            return CallResult(self._config, False, DROPPED if is_stopped() else nobody, False)
        self._topic.publish(self._message)
        return CallResult(self._config, True, "sent")


class _Action:
    """A goal, its result, and its end where it takes too long; by the topics of actionlib."""

    def __init__(self, config: DeviceCallConfig, keep_goal: Callable[[str], None]) -> None:
        self._config, self._keep_goal = config, keep_goal
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

    def call(self, is_stopped: Callable[[], bool] = never) -> CallResult:
        goal_id = self._new_id()
        self._keep_goal(goal_id.id)
        result = self._carry_out(goal_id, is_stopped)
        self._keep_goal("")
        return result

    def _carry_out(self, goal_id: GoalID, is_stopped: Callable[[], bool]) -> CallResult:
        end = time.monotonic() + self._config.within
        if not _wait(self._topic, self._config.within, is_stopped):
            nobody = f"nobody serves {self._config.target}"
            return CallResult(self._config, False, DROPPED if is_stopped() else nobody, False)
        goal_id.stamp = self._goal.header.stamp = rospy.Time.now()
        self._goal.goal_id = goal_id
        self._topic.publish(self._goal)
        while (left := end - time.monotonic()) > 0.0 and not is_stopped():
            try:
                result = self._results.get(timeout=min(left, STEP))
            except Empty:
                continue
            if result.status.goal_id.id == goal_id.id:
                status, words = result.status.status, result.status.text
                is_done = status == GoalStatus.SUCCEEDED
                return CallResult(self._config, is_done, words, status not in NOT_BEGUN)
        self._cancel.publish(GoalID(id=goal_id.id))  # its stamp would cancel all goals before it
        why = "a stop came" if is_stopped() else f"no result within {self._config.within:g} s"
        return CallResult(self._config, False, f"{why}; cancelled")


_KINDS: Mapping[str, Callable[[DeviceCallConfig], Target]] = {
    "service": _Service,
    "topic": _Topic,
}
_publishers: dict[tuple[str, type], rospy.Publisher] = {}


def _publisher(target: str, kind: type) -> rospy.Publisher:
    """One for each topic, however many calls go to it."""
    if (target, kind) not in _publishers:
        _publishers[target, kind] = rospy.Publisher(target, kind, queue_size=10)
    return _publishers[target, kind]


def _wait(topic: rospy.Publisher, within: float, is_stopped: Callable[[], bool]) -> bool:
    """Whether a device listens to a topic in time, and no stop came; an observer is none."""
    end, observers = time.monotonic() + within, set(map(of_this_system, OBSERVERS))
    while not open_listeners(topic) - observers and not is_stopped():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return not is_stopped()
