# SPDX-License-Identifier: BSD-3-Clause
"""Where commands in words arrive, from any thread, and are answered.

They are read, verified one at a time and handed to the executor. A stop never waits here: it goes
straight to the executor, whatever else is being checked.
"""

from __future__ import annotations

import math
import queue
import re
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field

from rst_control.execution.executor import Executor
from rst_control.execution.orders import Order, Outcome, Reply
from rst_control.planning.plan import Accepted, Plan, Rejected, Request, Situation
from rst_control.types import BY_HAND, Cause, Command, Reason

Verify = Callable[[Request, Situation], Accepted | Rejected]

COMMANDS = {command.value: command for command in Command}
WAITING = 16  # commands that may wait to be verified; more are refused at once
ATTEMPTS = 5  # to verify a command while the situation keeps changing
LONGEST = 200  # characters that a command may have with its spaces; the longest one has 15
ECHOED = 80  # characters of an unknown command that a refusal repeats
_SPACES = re.compile(r"[ \t\r\n]+")
_WORD = re.compile(r"\w+")


@dataclass(frozen=True, eq=False)
class Ticket:
    """What a caller gets: the answer to come, and how the motion ends."""

    request: Request
    caller: str
    is_spoken: bool
    owner: str = ""
    reply: Future[Reply] = field(default_factory=Future)
    ended: Future[Outcome] = field(default_factory=Future)
    attempts: int = 0


class CommandDesk:
    """Takes commands and answers each one.

    Args:
        executor: Who carries them out.
        verify: Plans a command and tells whether it may run.
        clock: Time [s], as the executor's ticks are given it.
    """

    def __init__(self, executor: Executor, verify: Verify, clock: Callable[[], float]) -> None:
        self._executor, self._verify, self._clock = executor, verify, clock
        self._waiting: queue.Queue[Ticket] = queue.Queue(WAITING)

    def take(
        self,
        request: Request,
        caller: str,
        is_spoken: bool = False,
        is_by_hand: bool = True,
        objection: Cause | None = None,
        owner: str = "",
    ) -> Ticket:
        """Take a command; returns at once, with the answer to come in the ticket.

        Args:
            request: The command in words, and its parameters.
            caller: Who gives it, for the diary.
            is_spoken: It came by voice: that node's heartbeat must go on while it is carried out.
            is_by_hand: It came from elsewhere than the voice node, alive or not.
            objection: Why nothing but a stop is taken from this caller; None: anything is.
            owner: Node that has to stay while it is carried out; empty: none has.
        """
        ticket = Ticket(request, caller, is_spoken, owner)
        command = read_command(request.words)
        if command is Command.STOP:
            cause = Cause(Reason.STOP_COMMAND, f'"stop" from {caller}')
            self._executor.stop(cause, self._clock())
            ticket.reply.set_result(Reply(True, 'stops and holds; say "hey robot" to go on'))
            ticket.ended.set_result(Outcome("succeeded", ""))
        elif command in BY_HAND and (is_spoken or not is_by_hand):
            words = f'"{command.value}" is given by hand, never by voice'
            self._refuse(ticket, Cause(Reason.BY_HAND_ONLY, words))
        elif objection is not None:
            self._refuse(ticket, objection)
        elif command is None:
            self._refuse(ticket, unknown(request.words))
        elif command in (Command.HEY_ROBOT, Command.TERMINATE):
            self._post(ticket, Plan(command, _WORDS[command]), serial=-1)
        elif not _is_amount(request.tension) or not _is_amount(request.distance):
            words = "tension and distance must be numbers from 0 up"
            self._refuse(ticket, Cause(Reason.BAD_AMOUNT, words))
        else:
            self._queue(ticket)
        return ticket

    def next(self, timeout: float) -> Ticket | None:
        """Wait for the next command to verify; None where none came in time."""
        try:
            return self._waiting.get(timeout=timeout)
        except queue.Empty:
            return None

    def check(self, ticket: Ticket) -> None:
        """Verify one command, in the view of this moment, and hand it over or refuse it."""
        view = self._executor.view
        decision = self._verify(ticket.request, view.situation(self._clock()))
        if isinstance(decision, Rejected):
            self._refuse(ticket, decision)
        else:
            self._post(ticket, decision.plan, view.serial)

    def fail(self, ticket: Ticket, error: Exception) -> None:
        """Refuse a command whose verification raised."""
        words = f"error while checking the command: {error!r}"[:300]
        self._refuse(ticket, Cause(Reason.CHECK_FAILED, words))

    def _queue(self, ticket: Ticket) -> None:
        try:
            self._waiting.put_nowait(ticket)
        except queue.Full:
            words = f"{WAITING} commands are waiting already"
            self._refuse(ticket, Cause(Reason.QUEUE_FULL, words))

    def _again(self, ticket: Ticket) -> None:
        if ticket.attempts >= ATTEMPTS:
            words = "the situation keeps changing; say it again"
            self._refuse(ticket, Cause(Reason.SITUATION_CHANGING, words))
            return
        again = Ticket(
            ticket.request,
            ticket.caller,
            ticket.is_spoken,
            ticket.owner,
            ticket.reply,
            ticket.ended,
            ticket.attempts + 1,
        )
        self._queue(again)

    def _post(self, ticket: Ticket, plan: Plan, serial: int) -> None:
        order = Order(
            plan,
            serial,
            ticket.is_spoken,
            ticket.owner,
            reply=ticket.reply.set_result,
            stale=(lambda: self._again(ticket)) if plan.phases else None,
            ended=ticket.ended.set_result,
        )
        self._executor.post(order)

    def _refuse(self, ticket: Ticket, cause: Cause) -> None:
        self._executor.note_refusal(shown(ticket.request.words), cause, self._clock())
        ticket.reply.set_result(Reply.refused(cause))
        ticket.ended.set_result(Outcome("refused", cause.words, cause.reason))


_WORDS = {Command.HEY_ROBOT: "ready", Command.TERMINATE: "finishes braking, holds and stands by"}


def read_command(words: str) -> Command | None:
    """Command that the words are; None where they are none.

    Case and spaces do not matter. A text that is longer than LONGEST, or holds anything but ASCII,
    is no command, whatever it looks like: only a stop is read more kindly.
    """
    if is_stop(words):
        return Command.STOP
    if len(words) > LONGEST or not words.isascii():
        return None
    return COMMANDS.get(_SPACES.sub(" ", words.lower()).strip(" "))


def is_stop(words: str) -> bool:
    """Whether the words say "stop" and nothing else, once or more, with whatever marks around.

    Of a text too long to be a command the beginning decides: what begins as a stop stops.
    """
    said = _WORD.findall(words[:LONGEST].lower())
    if len(words) > LONGEST and len(said) > 1:
        said.pop()  # it may be cut
    return bool(said) and set(said) == {Command.STOP.value}


def unknown(words: str, length: int = 0) -> Cause:
    """Reason for refusing words that are no command, with the list of those that are.

    Args:
        words: What was said, or its beginning.
        length: Of all that was said [bytes], where `words` is only its beginning.
    """
    oddity = f" of {length} bytes, allowed: {LONGEST}" if length else _oddity(words)
    words = f"unknown command {shown(words)!r}{oddity}; say one of: {', '.join(COMMANDS)}"
    return Cause(Reason.UNKNOWN_COMMAND, words)


def _oddity(words: str) -> str:
    """What keeps words from being a command, beside what they say; empty: nothing does."""
    if len(words) > LONGEST:
        return f" of {len(words)} characters, allowed: {LONGEST}"
    if words.isascii():
        return ""
    first = next(c for c in words if not c.isascii())
    return f" with U+{ord(first):04X}, which no command has"


def shown(words: str, longest: int = ECHOED) -> str:
    """Beginning of a text of others, on one line, as it may be repeated to people."""
    return "".join(c if c.isprintable() else "?" for c in words[:longest])


def _is_amount(value: float) -> bool:
    return math.isfinite(value) and value >= 0.0
