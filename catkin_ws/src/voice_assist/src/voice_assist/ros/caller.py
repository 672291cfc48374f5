# SPDX-License-Identifier: BSD-3-Clause
"""Asks the controller for commands from a thread of its own, so that no answer delays hearing."""

from __future__ import annotations

import threading
from collections.abc import Callable
from queue import Empty, Queue

import rospy

from rst_control.srv import Command
from voice_assist.dialogue import Answered

SERVICE = "rst_control/command"
_IDLE = 1.0  # [s] between looks whether the controller is there
_MISSING = "the robot's controller is missing"


class CommandCaller:
    """One call at a time over a connection that is kept open."""

    def __init__(self, answer_within: float, on_answer: Callable[[Answered], None]) -> None:
        """Start the thread.

        Args:
            answer_within: Longest wait for an answer [s].
            on_answer: Told every answer, in the caller's thread.
        """
        self._within, self._on_answer = answer_within, on_answer
        self._queue: Queue[str] = Queue()
        self._proxy: rospy.ServiceProxy | None = None
        self.trouble = ""  # what is wrong with the controller, in words
        threading.Thread(target=self._run, name="caller", daemon=True).start()

    def call(self, command: str, may_repeat: bool) -> None:
        """Ask for a command, after those asked before.

        Args:
            command: In words.
            may_repeat: Saying it twice does no harm, so it is sent again on a lost connection.
        """
        self._queue.put(("+" if may_repeat else "-") + command)

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
                entry = self._queue.get(timeout=_IDLE)
            except Empty:
                self._look()
                continue
            try:
                answered = self._ask(entry[1:], entry[0] == "+")
            except Exception as error:  # top of a thread: report, and go on
                rospy.logerr("calling the controller: %r", error)
                answered = Answered(entry[1:], False, repr(error))
            self._on_answer(answered)

    def _look(self) -> None:
        try:
            found = rospy.get_master().lookupService(rospy.resolve_name(SERVICE))[0] == 1
        except OSError:
            found = False
        self.trouble = "" if found else f"{_MISSING}: no service {rospy.resolve_name(SERVICE)}"

    def _ask(self, command: str, may_repeat: bool) -> Answered:
        was_connected = self._proxy is not None
        answered = self._once(command)
        if answered is None and was_connected and may_repeat:
            answered = self._once(command)  # the controller may have been started anew
        self.trouble = "" if answered else f"{_MISSING}: no answer from {SERVICE}"
        return answered or Answered(command, False, f"{_MISSING} or does not answer")

    def _once(self, command: str) -> Answered | None:
        """One attempt; None: no connection, or no answer in time."""
        proxy = self._proxy or rospy.ServiceProxy(SERVICE, Command, persistent=True)
        self._proxy = proxy
        box: Queue[Answered | None] = Queue(1)

        def ask() -> None:
            try:
                reply = proxy(command)
                box.put(Answered(command, bool(reply.accepted), reply.message))
            except (rospy.ServiceException, rospy.ROSException, OSError):
                box.put(None)

        threading.Thread(target=ask, name="call", daemon=True).start()
        try:
            answered = box.get(timeout=self._within)
        except Empty:
            answered = None
        if answered is None:
            self._proxy = None
            proxy.close()
        return answered
