# SPDX-License-Identifier: BSD-3-Clause
"""Hears the recorders' heartbeats, and says on the screen and in diagnostics when they are lost."""

from __future__ import annotations

import time
from collections.abc import Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import String

from rst_control.admission.recording_gate import RecordingNews, RecordingWatch
from rst_control.commands.parser import shown
from rst_control.execution.executor import Executor
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.ros.controller.diagnostics import make_status
from rst_control.ros.controller.messages import caller_of, code_of
from rst_control.types import Reason, State
from typed_config.ros.known_publishers import KnownPublishers

LONGEST_PROBLEM = 200  # characters of what a recorder says is wrong with it
MAX_RECORDERS = 16  # that are counted one by one
OTHERS = "another recorder"
GRACE = 15.0  # [s] after the start, within which a recorder that is not there yet is no news


class RecordingLink:
    """Feeds the watch, and acts on what it finds.

    Args:
        watch: Knows of the recording.
        executor: Brakes the motion under way where the setting says so.
        known: Makes the subscriber.
        recorders: Nodes that are believed to record.
    """

    def __init__(
        self,
        watch: RecordingWatch,
        executor: Executor,
        known: KnownPublishers,
        recorders: Sequence[str],
    ) -> None:
        self._watch, self._executor = watch, executor
        self._senders: set[str] = set()
        self._news = RecordingNews(watch, GRACE, time.monotonic)
        self._subscriber = known.subscribe(
            "session_log/recording",
            String,
            self._on_beat,
            recorders,
            tcp_nodelay=True,
            queue_size=1,
        )

    @property
    def recorders(self) -> frozenset[str]:
        """Names of the nodes that have said that they record."""
        return frozenset(self._senders - {OTHERS})

    def lost(self, recorder: str, words: str) -> None:
        """Note what has become of one, before its silence shows it."""
        self._watch.lost(recorder, words)

    def check(self, view: ControllerSnapshot) -> None:
        """Stop what may not go on unrecorded, and log what is new."""
        if view.mode.state is State.MOVING and (cause := self._watch.stop_cause(view.plan)):
            self._executor.stop(cause)
        news = self._news.next()
        if news is None:
            return
        is_loss, words = news
        if not is_loss:
            rospy.loginfo("%s", words)
        elif self._watch.is_ignored:
            rospy.logwarn("%s", words)
        else:
            rospy.logerr("%s", words)

    def status(self) -> DiagnosticStatus:
        """What diagnostics say of it."""
        problem, level = self._watch.problem, DiagnosticStatus.OK
        if problem and not (self._watch.is_ignored and not self._watch.was_heard):
            level = DiagnosticStatus.WARN if self._watch.is_ignored else DiagnosticStatus.ERROR
        words = f"not recorded: {problem}" if problem else "recorded"
        values = {
            "reason_code": code_of(Reason.NOT_RECORDED if problem else None),
            "on loss": self._watch.consequence,
        }
        return make_status("recording", level, words, values)

    def _on_beat(self, message: String) -> None:
        sender = caller_of(message)
        if len(self._senders) >= MAX_RECORDERS and sender not in self._senders:
            sender = OTHERS
        self._senders.add(sender)
        self._watch.heard(sender, shown(message.data, LONGEST_PROBLEM))
