# SPDX-License-Identifier: BSD-3-Clause
"""Commands in words arrive here, from any thread, and are answered.

They are read, verified one at a time and handed to the executor. A stop never waits here. It goes
straight to the executor, even while another command is being checked.
"""

from __future__ import annotations

import queue
from collections.abc import Callable, Mapping
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Final

from rst_control.commands.parser import read_request, shown
from rst_control.commands.request import Accepted, Plan, Request, Situation
from rst_control.commands.spec import CommandSpec, Role
from rst_control.commands.table import COMMANDS
from rst_control.execution.executor import Executor
from rst_control.execution.orders import GIVEN_UP, OUTRUN, Order, Outcome, Reply
from rst_control.types import Cause, Reason, Rejected

Verify = Callable[[Request, Situation], Accepted | Rejected]

WAITING: Final = 16  # commands that may wait to be verified; more are refused at once
ATTEMPTS: Final = 5  # to verify a command while the situation keeps changing


@dataclass(frozen=True, eq=False)
class PendingCommand:
    """What a caller gets: the answer to come, and how the motion ends.

    A caller that no longer waits cancels `reply`; the command is then not carried out.
    """

    words: str
    caller: str  # for the event log
    reply: Future[Reply] = field(default_factory=Future)
    ended: Future[Outcome] = field(default_factory=Future)

    def answer(self, reply: Reply) -> None:
        """Give the answer, unless the caller has given the command up."""
        with suppress(InvalidStateError):
            self.reply.set_result(reply)


@dataclass(frozen=True, eq=False)
class QueuedCommand:
    """A command that waits to be verified."""

    request: Request
    pending: PendingCommand
    is_spoken: bool
    owner: str
    latches: int  # of the executor, when it was given
    attempts: int = 0


class CommandQueue:
    """Takes commands and answers each one.

    Args:
        executor: Carries them out.
        verify: Plans a command and decides whether it may run.
        clock: Time [s], the clock of the executor's ticks.
        commands: All commands by their phrases.
    """

    def __init__(
        self,
        executor: Executor,
        verify: Verify,
        clock: Callable[[], float],
        commands: Mapping[str, CommandSpec] = COMMANDS,
    ) -> None:
        self._executor, self._verify, self._clock = executor, verify, clock
        self._commands = commands
        self._waiting: queue.Queue[QueuedCommand] = queue.Queue(WAITING)
        self.last_command = float("-inf")  # [s] when the last one came

    def take(
        self,
        words: str,
        caller: str,
        is_spoken: bool = False,
        is_by_hand: bool = True,
        refusal: Cause | None = None,
        owner: str = "",
        tension: float = 0.0,
        distance: float = 0.0,
    ) -> PendingCommand:
        """Take a command; returns at once, with the answer to come.

        Args:
            words: The command.
            caller: Who gives it, for the event log.
            is_spoken: It came by voice: that node's heartbeat must go on while it is carried out.
            is_by_hand: It came from elsewhere than the voice node, alive or not.
            refusal: Why nothing but a stop is taken from this caller; None: anything is.
            owner: Node that has to stay while it is carried out; empty: none has.
            tension: [N], 0: as configured.
            distance: [m], 0: as configured.
        """
        self.last_command = self._clock()
        pending = PendingCommand(words, caller)
        request = read_request(words, tension, distance, self._commands)
        is_by_voice = is_spoken or not is_by_hand
        if isinstance(request, Rejected):
            self._refuse(pending, refusal or request)
        elif request.command.role is Role.STOP:
            cause = Cause(Reason.STOP_COMMAND, f'"stop" from {caller}')
            self._executor.stop(cause, self._clock(), caller)
            pending.answer(Reply(True, request.command.reply))
            pending.ended.set_result(Outcome("succeeded", ""))
        elif request.command.is_by_hand_only and is_by_voice:
            by_hand = f'"{request.command.phrase}" is given by hand, never by voice'
            self._refuse(pending, Cause(Reason.BY_HAND_ONLY, by_hand))
        elif refusal is not None:
            self._refuse(pending, refusal)
        else:
            latches = self._executor.latches
            self._accept(QueuedCommand(request, pending, is_spoken, owner, latches))
        return pending

    def next(self, timeout: float) -> QueuedCommand | None:
        """Wait for the next command to verify; None where none came in time."""
        try:
            return self._waiting.get(timeout=timeout)
        except queue.Empty:
            return None

    def check(self, queued: QueuedCommand) -> None:
        """Verify one command, in the view of this moment, and hand it over or refuse it."""
        if queued.pending.reply.cancelled():
            self._refuse(queued.pending, GIVEN_UP)
            return
        view = self._executor.snapshot
        decision = self._verify(queued.request, view.situation(self._clock()))
        if queued.latches != self._executor.latches:  # it may come after the next "hey robot"
            self._refuse(queued.pending, Cause(Reason.HALTED, OUTRUN))
        elif isinstance(decision, Rejected):
            self._refuse(queued.pending, decision)
        else:
            self._post(queued, decision, view.serial)

    def fail(self, queued: QueuedCommand, error: Exception) -> None:
        """Refuse a command whose verification raised."""
        words = f"error while checking the command: {error!r}"[:300]
        self._refuse(queued.pending, Cause(Reason.CHECK_FAILED, words))

    def _accept(self, queued: QueuedCommand) -> None:
        command = queued.request.command
        if command.plan is None and command.role is not Role.SET_UP:
            self._post(queued, Accepted(Plan(command, command.reply)), serial=-1)
        else:
            self._queue(queued)

    def _queue(self, queued: QueuedCommand) -> None:
        try:
            self._waiting.put_nowait(queued)
        except queue.Full:
            words = f"{WAITING} commands are waiting already"
            self._refuse(queued.pending, Cause(Reason.QUEUE_FULL, words))

    def _again(self, queued: QueuedCommand) -> None:
        if queued.attempts >= ATTEMPTS:
            words = "the situation keeps changing; say it again"
            self._refuse(queued.pending, Cause(Reason.SITUATION_CHANGING, words))
        else:
            self._queue(replace(queued, attempts=queued.attempts + 1))

    def _post(self, queued: QueuedCommand, decision: Accepted, serial: int) -> None:
        order = Order(
            decision.plan,
            serial,
            queued.latches,
            queued.is_spoken,
            queued.owner,
            queued.pending.caller,
            claim=queued.pending.reply.set_running_or_notify_cancel,
            reply=queued.pending.answer,
            stale=(lambda: self._again(queued)) if decision.plan.phases else None,
            started=decision.started,
            ended=queued.pending.ended.set_result,
        )
        self._executor.post(order)

    def _refuse(self, pending: PendingCommand, cause: Cause) -> None:
        said, now = shown(pending.words), self._clock()
        self._executor.note_refusal(said, cause, now, pending.caller)
        pending.answer(Reply.refused(cause))
        pending.ended.set_result(Outcome("refused", cause.words, cause.reason))
