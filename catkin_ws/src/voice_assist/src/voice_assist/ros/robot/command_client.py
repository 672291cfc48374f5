# SPDX-License-Identifier: BSD-3-Clause
"""Asks the controller for commands from a thread of its own, so that no answer delays hearing."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from queue import Empty, Queue

import rospy

from rst_control.srv import Command, CommandRequest
from typed_config.ros.service_calls import drop, has_ended, in_time, timely
from voice_assist.intent.dialogue import Answered

SERVICE = "rst_control/command"
_IDLE = 1.0  # [s] between checks that the controller is there
_MISSING = "the robot's controller is missing"


@dataclass(frozen=True)
class _Request:
    command: str
    may_repeat: bool
    send_by: float  # [s] steady clock; after it the speaker has been notified of the failure


class CommandClient:
    """One call at a time over a connection that is kept open."""

    def __init__(self, answer_within: float, on_answer: Callable[[Answered], None]) -> None:
        """Start the thread.

        Args:
            answer_within: Longest wait for an answer [s].
            on_answer: Called with every answer, in this client's thread.
        """
        self._within, self._on_answer = answer_within, on_answer
        self._queue: Queue[_Request] = Queue()
        self._proxy: rospy.ServiceProxy | None = None
        self.trouble = ""  # what is wrong with the controller, in words
        threading.Thread(target=self._run, name="command client", daemon=True).start()

    def call(self, command: str, may_repeat: bool) -> None:
        """Ask for a command, after those asked before.

        Args:
            command: In words.
            may_repeat: Saying it twice does no harm, so it is sent again on a lost connection.
        """
        self._queue.put(_Request(command, may_repeat, time.monotonic() + self._within))

    def forget(self) -> None:
        """Drop what has not been sent yet: a stop makes it void."""
        while True:
            try:
                self._queue.get_nowait()
            except Empty:
                return

    def _run(self) -> None:
        while not rospy.is_shutdown():
            try:
                request = self._queue.get(timeout=_IDLE)
            except Empty:
                self._check_controller()
                continue
            try:
                answered = self._ask(request)
            except Exception as error:  # top of a thread: report, and go on
                rospy.logerr("calling the controller: %r", error)
                answered = Answered(request.command, False, repr(error))
            self._on_answer(answered)

    def _check_controller(self) -> None:
        name = rospy.resolve_name(SERVICE)
        found = in_time(lambda: rospy.get_master().lookupService(name)[0] == 1, self._within)
        self.trouble = "" if found else f"{_MISSING}: no service {name}"

    def _ask(self, request: _Request) -> Answered:
        if self._proxy is not None and has_ended(self._proxy):
            self._disconnect()  # the controller may have been started anew
        was_connected = self._proxy is not None
        answered = self._once(request)
        if answered is None and was_connected and request.may_repeat:
            answered = self._once(request)  # it may have ended just now, or its host
        self.trouble = "" if answered else f"{_MISSING}: no answer from {SERVICE}"
        words = f"{_MISSING} or does not answer within {self._within:g} s"
        return answered or Answered(request.command, False, words)

    def _once(self, request: _Request) -> Answered | None:
        """One attempt; None: no connection, or no answer in time, and nothing comes later."""
        proxy = self._proxy or rospy.ServiceProxy(SERVICE, Command, persistent=True)
        self._proxy = proxy
        asked = timely(CommandRequest, request.send_by)(request.command)

        def ask() -> Answered:
            reply = proxy(asked)
            return Answered(request.command, bool(reply.accepted), reply.message)

        answered = in_time(ask, self._within)
        if answered is None:
            self._disconnect()
        return answered

    def _disconnect(self) -> None:
        if self._proxy is not None:
            drop(self._proxy)
            self._proxy = None
