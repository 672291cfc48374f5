# SPDX-License-Identifier: BSD-3-Clause
"""The action `rst_control/execute`: goals go the same way as commands; cancelling one stops.

Each goal ends in exactly one terminal state. actionlib's callbacks only hand over, so that its
lock is never held for long, and a thread of its own passes endings on, not the control loop.
"""

from __future__ import annotations

import queue
import time
from collections import deque
from collections.abc import Callable

import actionlib
import rospy
from actionlib import ServerGoalHandle
from actionlib_msgs.msg import GoalID, GoalStatus

from rst_control.admission.callers import CallLimiter
from rst_control.admission.command_queue import CommandQueue
from rst_control.commands.parser import is_stop, shown
from rst_control.execution.executor import Executor
from rst_control.execution.orders import Outcome, Reply
from rst_control.msg import AssistAction, AssistActionGoal
from rst_control.ros.controller.messages import caller_of, feedback_message, result_message
from rst_control.types import Cause, Reason
from typed_config.node_names import UNNAMED
from typed_config.ros.known_publishers import KnownPublishers

OnGoal = Callable[[ServerGoalHandle], None]

MAX_GOALS = 200  # that actionlib remembers; it forgets one 5 s after it has ended
LONGEST_ID = 200  # characters of a goal's id
SAY_AGAIN = 1.0  # [s] between two words on goals refused


class GuardedServer(actionlib.ActionServer):
    """An action server that knows who sends goals, and does not remember them without limit.

    Args:
        limiter: Knows who may command, and how often.
        known: Knows whether a name that a goal claims is true.
        on_stop: Gets every goal that is a stop, before anything is asked about it.
        on_goal: Gets every goal that is let in.
        on_cancel: Gets every goal that is to be cancelled; a cancel is never turned away.
        on_cancel_all: Gets every cancel that names no goal, also where none is under way.
        on_late_cancel: Gets every cancel of a goal of `replaced`.

    Attributes:
        replaced: Ids of goals that another motion took the place of.
    """

    def __init__(
        self,
        limiter: CallLimiter,
        known: KnownPublishers,
        on_stop: Callable[[AssistActionGoal], None],
        on_goal: OnGoal,
        on_cancel: OnGoal,
        on_cancel_all: Callable[[GoalID], None],
        on_late_cancel: Callable[[GoalID], None],
    ) -> None:
        self._limiter, self._on_stop = limiter, on_stop
        self._on_cancel_all, self._on_late_cancel = on_cancel_all, on_late_cancel
        self.replaced: deque[str] = deque(maxlen=MAX_GOALS)
        self._goals = known.watch()
        super().__init__("rst_control/execute", AssistAction, on_goal, on_cancel, auto_start=False)

    def start(self) -> None:
        """Begin to take goals."""
        super().start()
        self._goals.subscriber = self.goal_sub

    def internal_goal_callback(self, goal: AssistActionGoal) -> None:
        """Turn a goal away, or let actionlib take it.

        Of a stop actionlib only keeps the books. It would drop one whose id, or whose time, was
        cancelled; and the master, which may hang, is asked about who sends a first goal.
        """
        if is_stop(goal.goal.command):
            self._on_stop(goal)
        goal.goal_id.stamp = _not_after_now(goal.goal_id.stamp)
        admission = self._limiter.admit(caller_of(goal), is_stop(goal.goal.command))
        refusal = admission.refusal or self._unheard(goal) or self._too_much(goal.goal_id)
        if refusal is not None:
            rospy.logwarn_throttle(SAY_AGAIN, f"goal refused: {refusal.words}")
        if refusal is not None and not is_stop(goal.goal.command):
            status = GoalStatus(_short(goal.goal_id), GoalStatus.REJECTED, refusal.words)
            outcome = Outcome("refused", refusal.words, refusal.reason)
            self.publish_result(status, result_message(outcome))
        else:
            super().internal_goal_callback(goal)
        time.sleep(admission.pause)  # a flooding client waits: nothing is read from it meanwhile

    def internal_cancel_callback(self, goal_id: GoalID) -> None:
        """Cancel what is known; what is not known is remembered as long as there is room."""
        if not goal_id.id:
            self._on_cancel_all(goal_id)
        goal_id.stamp = _not_after_now(goal_id.stamp)
        with self.lock:
            known = [s.status for s in self.status_list if s.status.goal_id.id == goal_id.id]
        if goal_id.id in self.replaced:
            self._on_late_cancel(goal_id)
        if goal_id.id and not known and self._too_much(goal_id):
            if goal_id.stamp.is_zero():
                return
            goal_id = GoalID(goal_id.stamp, "")  # it still cancels all that is older
        super().internal_cancel_callback(goal_id)

    def _unheard(self, goal: AssistActionGoal) -> Cause | None:
        """Why a goal counts as nobody's: like a bag, its sender does not hear of its end."""
        caller, listeners = caller_of(goal), list(self.result_pub.impl.connections)
        if not self._goals.has_true_name(goal):
            return Cause(Reason.MAY_NOT_COMMAND, f"the goal came from elsewhere than {caller} is")
        if any(listener.endpoint_id == caller for listener in listeners):
            return None
        words = f"{caller} does not subscribe to the result of its goal; a bag that is played?"
        return Cause(Reason.MAY_NOT_COMMAND, words)

    def _too_much(self, goal_id: GoalID) -> Cause | None:
        if len(goal_id.id) > LONGEST_ID:
            words = f"a goal id of {len(goal_id.id)} characters, allowed: {LONGEST_ID}"
            return Cause(Reason.BAD_AMOUNT, words)
        known = len(self.status_list)
        words = f"{known} goals are known already, allowed: {MAX_GOALS}"
        return Cause(Reason.QUEUE_FULL, words) if known >= MAX_GOALS else None


class AssistServer:
    """Translates between actionlib and the queue of commands."""

    def __init__(
        self,
        commands: CommandQueue,
        executor: Executor,
        limiter: CallLimiter,
        known: KnownPublishers,
    ) -> None:
        self._commands, self._executor = commands, executor
        self._running: dict[str, ServerGoalHandle] = {}
        self._news: queue.SimpleQueue[tuple[ServerGoalHandle, Reply | Outcome]] = (
            queue.SimpleQueue()
        )
        cancels = self._on_cancel, self._on_cancel_all, self._on_late_cancel
        self._server = GuardedServer(limiter, known, self._on_stop, self._on_goal, *cancels)

    def start(self) -> rospy.Subscriber:
        """Begin to take goals; gives the subscriber by which they come."""
        self._server.start()
        return self._server.goal_sub

    def publish_feedback(self) -> None:
        """Send every running goal how far it is."""
        running = list(self._running.values())
        if running:
            feedback = feedback_message(self._executor.snapshot)
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
                goal.set_succeeded(result, outcome.message)
            case "refused":
                goal.set_rejected(result, outcome.message)
            case "stopped":
                if outcome.reason is Reason.REPLACED:
                    self._server.replaced.append(goal.get_goal_id().id)
                goal.set_canceled(result, outcome.message)
            case "failed":
                goal.set_aborted(result, outcome.message)

    def _on_stop(self, goal: AssistActionGoal) -> None:
        received, caller = time.monotonic(), caller_of(goal)
        cause = Cause(Reason.STOP_COMMAND, f'"stop" from action client {caller}')
        self._executor.stop(cause, received, caller)

    def _on_goal(self, goal: ServerGoalHandle) -> None:
        wanted = goal.get_goal()
        caller = caller_of(goal.goal)
        owner = "" if caller == UNNAMED else caller  # who leaves its goal alone stops it
        pending = self._commands.take(
            wanted.command,
            f"action client {caller}",
            owner=owner,
            tension=wanted.tension,
            distance=wanted.distance,
        )
        pending.reply.add_done_callback(lambda reply: self._news.put((goal, reply.result())))
        pending.ended.add_done_callback(lambda ended: self._news.put((goal, ended.result())))

    def _on_cancel(self, goal: ServerGoalHandle) -> None:
        received, command = time.monotonic(), shown(goal.get_goal().command, 40)
        words = f'stop by cancelling the action "{command}"'
        self._executor.stop(Cause(Reason.STOP_CANCEL, words), received, caller_of(goal.goal))

    def _on_cancel_all(self, goal_id: GoalID) -> None:
        self._stop_by("all actions", goal_id)

    def _on_late_cancel(self, goal_id: GoalID) -> None:
        """What moves may have replaced the goal just now, unseen by who cancels it."""
        if self._executor.snapshot.is_moving:
            self._stop_by("an action that was replaced", goal_id)

    def _stop_by(self, what: str, goal_id: GoalID) -> None:
        received, caller = time.monotonic(), caller_of(goal_id)
        words = f"stop by cancelling {what}, from {caller}"
        self._executor.stop(Cause(Reason.STOP_CANCEL, words), received, caller)


def _short(goal_id: GoalID) -> GoalID:
    return GoalID(goal_id.stamp, goal_id.id[:LONGEST_ID])


def _not_after_now(stamp: rospy.Time) -> rospy.Time:
    """A stamp that a peer may give.

    One beyond 32 bits cannot be sent on, which would end actionlib's reports; and a cancel from the
    future would cancel all goals to come.
    """
    return stamp if stamp.is_zero() else min(stamp, rospy.Time.now())
