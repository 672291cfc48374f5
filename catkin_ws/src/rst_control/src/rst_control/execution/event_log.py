# SPDX-License-Identifier: BSD-3-Clause
"""What became of the commands: their answers, their endings, and the diary of it all."""

from __future__ import annotations

from collections import deque

from rst_control.execution.orders import DiaryEntry, DiaryKind, Order, Outcome, OutcomeKind, Reply
from rst_control.types import Cause, Reason

LONGEST_DIARY = 10_000  # [entries] kept where nobody takes them


class Ledger:
    """Answers orders, ends the one in motion once, and writes the diary.

    The control loop's thread calls it; `note_refusal` may come from any thread.
    """

    def __init__(self) -> None:
        self.diary: deque[DiaryEntry] = deque(maxlen=LONGEST_DIARY)  # emptied by its publisher
        self.order: Order | None = None  # the one in motion
        self.command = ""
        self.last_refusal: Cause | None = None

    @property
    def is_spoken(self) -> bool:
        """The order in motion was spoken."""
        return self.order is not None and self.order.is_spoken

    def note(
        self,
        now: float,
        kind: DiaryKind,
        command: str,
        message: str,
        reason: Reason | None = None,
    ) -> None:
        """Write what happened at a time [s]."""
        self.diary.append(DiaryEntry(now, kind, command, message, reason))

    def note_refusal(self, now: float, command: str, cause: Cause) -> None:
        """Write a refusal, wherever it was decided."""
        self.last_refusal = cause
        self.note(now, "refused", command, cause.words, cause.reason)

    def accept(self, now: float, order: Order) -> None:
        """Answer that it is done or will be."""
        self.command = order.command.phrase
        self.note(now, "accepted", self.command, order.plan.words)
        order.reply(Reply(True, order.plan.words))

    def refuse(self, now: float, order: Order, cause: Cause, tension: float) -> None:
        """Answer that it will not be done, and end it.

        Args:
            now: Time [s].
            order: Not in motion.
            cause: Why.
            tension: Present [N].
        """
        self.note_refusal(now, order.command.phrase, cause)
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
