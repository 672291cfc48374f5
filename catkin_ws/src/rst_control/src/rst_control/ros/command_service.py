# SPDX-License-Identifier: BSD-3-Clause
"""Commands in words: the string service, and the topic on which anyone may stop the robot."""

from __future__ import annotations

import time
from concurrent.futures import TimeoutError as NoReply

import rospy
from std_msgs.msg import Empty, Time

from rst_control.desk import CommandDesk
from rst_control.executor import Executor
from rst_control.srv import Command, CommandRequest, CommandResponse
from rst_control.types import Request

REPLY_TIME = 2.0  # [s] within which every command is answered, or the caller told that it was not


class CommandService:
    """Serves `rst_control/command`; listens to `rst_control/stop` and `rst_control/heartbeat`.

    Args:
        desk: Takes the commands.
        executor: Takes stops and heartbeats.
        spoken_by: Name of the node whose commands count as spoken.
        heartbeat_age: Age of the last heartbeat up to which that node counts as alive [s].
    """

    def __init__(
        self, desk: CommandDesk, executor: Executor, spoken_by: str, heartbeat_age: float
    ) -> None:
        self._desk, self._executor = desk, executor
        self._spoken_by, self._heartbeat_age = spoken_by, heartbeat_age
        self._last_heartbeat = float("-inf")
        self.last_command = float("-inf")  # [s] when the last command came, steady clock
        self._subscribers = [
            rospy.Subscriber("rst_control/stop", Empty, self._on_stop, tcp_nodelay=True),
            rospy.Subscriber("rst_control/heartbeat", Time, self._on_heartbeat, tcp_nodelay=True),
        ]
        self._service: rospy.Service | None = None

    def start(self) -> None:
        """Begin to take commands."""
        self._service = rospy.Service("rst_control/command", Command, self._on_command)

    def _on_command(self, request: CommandRequest) -> CommandResponse:
        self.last_command = time.monotonic()
        caller = request._connection_header.get("callerid", "an unnamed node")
        is_by_hand = caller != self._spoken_by
        ticket = self._desk.take(
            Request(request.command), caller, self._is_spoken(caller), is_by_hand
        )
        try:
            reply = ticket.reply.result(REPLY_TIME)
        except NoReply:
            return CommandResponse(
                False, "the controller does not answer; nothing is known to move"
            )
        return CommandResponse(reply.accepted, reply.message)

    def _is_spoken(self, caller: str) -> bool:
        is_alive = time.monotonic() - self._last_heartbeat <= self._heartbeat_age
        return is_alive and caller == self._spoken_by

    def _on_stop(self, message: Empty) -> None:
        caller = message._connection_header.get("callerid", "an unnamed node")
        self._executor.stop(f"stop topic, from {caller}")

    def _on_heartbeat(self, _: Time) -> None:
        self._last_heartbeat = time.monotonic()
        self._executor.heartbeat(self._last_heartbeat)
