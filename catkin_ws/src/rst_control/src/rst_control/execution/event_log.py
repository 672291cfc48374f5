# SPDX-License-Identifier: BSD-3-Clause
"""What became of the commands: their answers, their endings, and the log of all events."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Literal

from rst_control.execution.orders import Order, Outcome, OutcomeKind, Reply
from rst_control.types import Cause, Reason

EventKind = Literal[
    "accepted",
    "refused",
    "motion_started",
    "motion_finished",
    "stop_received",
    "at_rest",
    "halted",
    "cleared",
    "trocar_set",
    "trocar_refused",
    "grasp_set",
    "grasp_refused",
]
MAX_EVENTS = 10_000  # [entries] kept where nobody takes them


@dataclass(frozen=True)
class Event:
    """Something that happened, for the timeline and the report."""

    stamp: float  # [s]
    kind: EventKind
    command: str
    message: str
    reason: Reason | None = None  # of what was refused, stopped, halted, given up or cleared
    caller: str = ""  # node that asked, for what was accepted, refused or a stop


class EventLog:
    """Answers orders, ends the one in motion once, and writes the event log.

    The control loop's thread calls it; `note_refusal` may come from any thread.
    """

    def __init__(self) -> None:
        self.events: deque[Event] = deque(maxlen=MAX_EVENTS)  # emptied by its publisher
        self.order: Order | None = None  # the one in motion
        self.command = ""  # in execution, or the last one
        self.last_refusal: Cause | None = None

    @property
    def is_spoken(self) -> bool:
        """The order in motion was spoken."""
        return self.order is not None and self.order.is_spoken

    def note(
        self, now: float, kind: EventKind, command: str, why: Cause | str, caller: str = ""
    ) -> None:
        """Write what happened at a time [s], with its cause or in words, and who asked for it."""
        words, reason = (why.words, why.reason) if isinstance(why, Cause) else (why, None)
        self.events.append(Event(now, kind, command, words, reason, caller))

    def note_refusal(self, now: float, command: str, cause: Cause, caller: str) -> None:
        """Write a refusal, wherever it was decided."""
        self.last_refusal = cause
        self.note(now, "refused", command, cause, caller)

    def accept(self, now: float, order: Order) -> None:
        """Answer that it is done or will be."""
        words = order.plan.command_words
        if self.order is None or self.order is order:  # else another one is in motion
            self.command = words
        self.note(now, "accepted", words, order.plan.words, order.caller)
        order.reply(Reply(True, order.plan.words))

    def refuse(self, now: float, order: Order, cause: Cause, tension: float) -> None:
        """Answer that it will not be done, and end it.

        Args:
            now: Time [s].
            order: Not in motion.
            cause: Why.
            tension: Present [N].
        """
        self.note_refusal(now, order.plan.command_words, cause, order.caller)
        order.reply(Reply.refused(cause))
        order.ended(Outcome("refused", cause.words, cause.reason, tension))

    def end(self, kind: OutcomeKind, cause: Cause | None, tension: float, rcm_error: float) -> None:
        """End the order in motion, if there is one.

        Args:
            kind: How it ended.
            cause: Why it did not succeed; None where it did.
            tension: Present [N].
            rcm_error: Largest since the motion began [m].
        """
        order, self.order = self.order, None
        if order is not None:
            words, reason = (cause.words, cause.reason) if cause else ("", None)
            order.ended(Outcome(kind, words, reason, tension, rcm_error))
