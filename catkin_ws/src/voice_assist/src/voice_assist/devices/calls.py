# SPDX-License-Identifier: BSD-3-Clause
"""Which calls follow what was said, and which undo them at a stop."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

from voice_assist.config.devices import DeviceCallConfig, DevicesConfig

DROPPED: Final = "dropped by a stop"  # what came of a call that was not made
MAX_WAITING: Final = 5  # calls; of more the newest are refused


@dataclass(frozen=True)
class CallResult:
    """What came of a call, in words for people."""

    call: DeviceCallConfig
    is_done: bool
    words: str
    may_have_effect: bool = True  # False: the device refused it, or it was never sent


def result_words(phrase: str, is_done: bool, words: str) -> str:
    """What came of the call of a phrase, such as "light on: done"."""
    return f"{phrase}: {'done' if is_done else 'failed'}{f', {words}' if words else ''}"


class DeviceCalls:
    """Calls that wait to be made; commands and stops come from several threads.

    Two threads make them, so that what a stop undoes waits for no call at work: one takes `next`,
    the other `next_undoing`. Each tells `ended` what came of the call that it took.

    Args:
        config: The allow-list.
    """

    def __init__(self, config: DevicesConfig) -> None:
        self._config, self._changed = config, threading.Condition()
        self._waiting: deque[DeviceCallConfig] = deque()
        self._undoing: deque[DeviceCallConfig] = deque()
        self._is_undoing = False  # the call that `next_undoing` gave last is at work
        self._is_stopped = False  # a stop came after the call that `next` gave last
        # Phrases of calls to that of what undoes each, or "": calls at work, and those that had an
        # effect, or may have had one, since they were last undone.
        self._at_work: dict[str, str] = {}
        self._undone_by: dict[str, str] = {}
        self._of_restart: set[str] = set()  # phrases of what undoes calls of an earlier process
        self._again: deque[DeviceCallConfig] = deque()  # of these, what failed once

    def said(self, phrase: str) -> CallResult | None:
        """Let the call of a command wait, if it has one; gives why it is refused, else None."""
        call = self._config.get(phrase)
        if call is None:
            return None
        with self._changed:
            if len(self._waiting) >= MAX_WAITING:
                words = f"{len(self._waiting)} calls wait already, allowed: {MAX_WAITING}"
                return CallResult(call, False, words)
            self._waiting.append(call)
            self._changed.notify_all()
        return None

    def next(self, timeout: float) -> DeviceCallConfig | None:
        """The call to be made now; None: none came in time.

        While a stop's calls are made, none is given.

        Args:
            timeout: How long to wait for one [s].
        """
        with self._changed:
            if not self._changed.wait_for(self._is_next_due, timeout):
                return None
            self._is_stopped = False
            return self._begin(self._waiting.popleft())

    def next_undoing(self, timeout: float) -> DeviceCallConfig | None:
        """The call that undoes one now, as `next`; the one that it gave before has ended."""
        with self._changed:
            self._is_undoing = False
            self._changed.notify_all()
            if not self._changed.wait_for(lambda: self._undoing, timeout):
                self._undoing.extend(self._again)  # next time: after this pause
                self._again.clear()
                return None
            self._is_undoing = True
            return self._begin(self._undoing.popleft())

    def stop_check(self, call: DeviceCallConfig) -> Callable[[], bool]:
        """Whether a stop came since `next` gave a call; never of one that undoes another."""
        if call.phrase in {one.on_stop for one in self._config.calls}:
            return lambda: False
        return lambda: self._is_stopped

    def _is_next_due(self) -> bool:
        return bool(self._waiting) and not (self._undoing or self._again or self._is_undoing)

    def _begin(self, call: DeviceCallConfig) -> DeviceCallConfig:
        self._at_work[call.phrase] = call.on_stop
        return call

    def ended(self, result: CallResult) -> None:
        """Take in what came of a call that was given to be made.

        One that was done undoes the calls that name it. One that may have had an effect has to be
        undone from now on. It is undone at once where its undo was done meanwhile, or is at work:
        its effect may have come after that of the undo.
        """
        call = result.call
        with self._changed:
            was_undone = self._at_work.pop(call.phrase, None) is None
            if not result.is_done and call.phrase in self._of_restart:
                self._again.append(call)
            self._of_restart.discard(call.phrase)
            if result.is_done and call not in self._undoing:  # the last one counts
                for calls in (self._undone_by, self._at_work):
                    for phrase in [p for p, undo in calls.items() if undo == call.phrase]:
                        del calls[phrase]
            undo = self._config.get(call.on_stop)
            if undo is None or not (result.is_done or result.may_have_effect):
                return
            self._undone_by.pop(call.phrase, None)  # it is the newest now
            self._undone_by[call.phrase] = undo.phrase
            if was_undone or undo.phrase in self._at_work:
                self._undoing.append(undo)
                self._changed.notify_all()

    def to_undo(self) -> list[str]:
        """Phrases of the calls that a stop has to undo, the oldest first."""
        with self._changed:
            at_work = [phrase for phrase, undo in self._at_work.items() if undo]
            return list(dict.fromkeys([*self._undone_by, *at_work]))

    def undo(self, phrases: Iterable[str]) -> None:
        """Undo calls of an earlier process at once, as a stop does; `to_undo` named them there.

        What fails is tried again once, after a pause in which nothing else is to be undone.
        """
        with self._changed:
            calls = [call for phrase in phrases if (call := self._config.get(phrase))]
            self._undone_by.update({call.phrase: call.on_stop for call in calls if call.on_stop})
            self._of_restart = set(self._undone_by.values())
        self.stopped()

    def stopped(self) -> tuple[CallResult, ...]:
        """Drop what waits, and let what undoes the calls that were made be made.

        A call at work may have an effect already. Several messages may report one stop, so what is
        at work is not begun again; what failed is, by the next stop.

        Returns:
            What is dropped.
        """
        with self._changed:
            undos = [*self._undone_by.values(), *self._at_work.values()]
            newest_first = dict.fromkeys(reversed(undos))
            undoing = [undo for undo in newest_first if undo and undo not in self._at_work]
            dropped = [call for call in self._waiting if call.phrase not in undoing]
            self._waiting.clear()
            self._again.clear()
            self._undoing = deque(call for p in undoing if (call := self._config.get(p)))
            self._is_stopped = True
            self._changed.notify_all()
        return tuple(CallResult(call, False, DROPPED) for call in dropped)
