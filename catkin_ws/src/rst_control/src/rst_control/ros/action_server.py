# SPDX-License-Identifier: BSD-3-Clause
"""The action `rst_control/execute`: goals go the same way as commands; cancelling one stops.

Each goal ends in exactly one terminal state. actionlib's callbacks only hand over, so that its
lock is never held for long, and a thread of its own passes endings on, not the control loop.
"""

from __future__ import annotations

import queue

import actionlib
from actionlib import ServerGoalHandle

from rst_control.desk import CommandDesk
from rst_control.executor import Executor
from rst_control.msg import AssistAction
from rst_control.orders import Outcome, Reply
from rst_control.ros.messages import feedback_message, result_message
from rst_control.types import Request


class AssistServer:
    """Translates between actionlib and the desk."""

    def __init__(self, desk: CommandDesk, executor: Executor) -> None:
        self._desk, self._executor = desk, executor
        self._running: dict[str, ServerGoalHandle] = {}
        self._news: queue.SimpleQueue[tuple[ServerGoalHandle, Reply | Outcome]] = (
            queue.SimpleQueue()
        )
        self._server = actionlib.ActionServer(
            "rst_control/execute", AssistAction, self._on_goal, self._on_cancel, auto_start=False
        )

    def start(self) -> None:
        """Begin to take goals."""
        self._server.start()

    def publish_feedback(self) -> None:
        """Tell every running goal how far it is."""
        running = list(self._running.values())
        if running:
            feedback = feedback_message(self._executor.view)
            for goal in running:
                goal.publish_feedback(feedback)

    def take_news(self, timeout: float) -> None:
        """Pass the next answer or ending on to its client; where none comes, wait `timeout` [s]."""
        try:
            goal, news = self._news.get(timeout=timeout)
        except queue.Empty:
            return
        if isinstance(news, Outcome):
            self._end(goal, news)
        elif news.accepted:
            self._running[goal.get_goal_id().id] = goal
            goal.set_accepted(news.message)

    def _end(self, goal: ServerGoalHandle, outcome: Outcome) -> None:
        self._running.pop(goal.get_goal_id().id, None)
        result = result_message(outcome)
        match outcome.kind:
            case "succeeded":
                goal.set_succeeded(result, outcome.reason)
            case "refused":
                goal.set_rejected(result, outcome.reason)
            case "stopped":
                goal.set_canceled(result, outcome.reason)
            case "failed":
                goal.set_aborted(result, outcome.reason)

    def _on_goal(self, goal: ServerGoalHandle) -> None:
        wanted = goal.get_goal()
        request = Request(wanted.command, wanted.tension, wanted.distance)
        ticket = self._desk.take(request, "an action client")
        ticket.reply.add_done_callback(lambda reply: self._news.put((goal, reply.result())))
        ticket.ended.add_done_callback(lambda ended: self._news.put((goal, ended.result())))

    def _on_cancel(self, goal: ServerGoalHandle) -> None:
        self._executor.stop(f'stop by cancelling the action "{goal.get_goal().command[:40]}"')
