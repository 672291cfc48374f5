# SPDX-License-Identifier: BSD-3-Clause
"""Which calls follow what was said, and which undo them at a stop."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
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


def result_words(phrase: str, is_done: bool, words: str) -> str:
    """What came of the call of a phrase, such as "light on: done"."""
    return f"{phrase}: {'done' if is_done else 'failed'}{f', {words}' if words else ''}"


class DeviceCalls:
    """Calls that wait to be made; commands and stops come from several threads.

    Two threads make them, so that what a stop undoes waits for no call at work: one takes `next`,
    the other `next_undoing`.

    Args:
        config: The allow-list.
    """

    def __init__(self, config: DevicesConfig) -> None:
        self._config, self._changed = config, threading.Condition()
        self._waiting: deque[DeviceCallConfig] = deque()
        self._undoing: deque[DeviceCallConfig] = deque()
        self._is_undoing = False  # the call that `next_undoing` gave last is at work
        self._is_stopped = False  # a stop came after the call that `next` gave last
        self._undone_by: dict[str, str] = {}  # phrase of a call that was made: of what undoes it

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
        """The call to be made now, which counts as made; None: none came in time.

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
                return None
            self._is_undoing = True
            return self._begin(self._undoing.popleft())

    def stop_check(self, call: DeviceCallConfig) -> Callable[[], bool]:
        """Whether a stop came since `next` gave a call; never of one that undoes another."""
        if call.phrase in {one.on_stop for one in self._config.calls}:
            return lambda: False
        return lambda: self._is_stopped

    def _is_next_due(self) -> bool:
        return bool(self._waiting) and not (self._undoing or self._is_undoing)

    def _begin(self, call: DeviceCallConfig) -> DeviceCallConfig:
        self._undone_by = {p: u for p, u in self._undone_by.items() if u != call.phrase}
        # From its beginning on: whether a call that failed had an effect is not known.
        if call.on_stop:
            self._undone_by[call.phrase] = call.on_stop
        return call

    def stopped(self) -> tuple[CallResult, ...]:
        """Drop what waits, and let what undoes the calls that were made be made.

        Several messages may report one stop. So what undoes a call stays until it is made itself.

        Returns:
            What is dropped.
        """
        with self._changed:
            undoing = list(dict.fromkeys(reversed(self._undone_by.values())))  # newest first
            dropped = [call for call in self._waiting if call.phrase not in undoing]
            self._waiting.clear()
            self._undoing = deque(call for p in undoing if (call := self._config.get(p)))
            self._is_stopped = True
            self._changed.notify_all()
        return tuple(CallResult(call, False, DROPPED) for call in dropped)
