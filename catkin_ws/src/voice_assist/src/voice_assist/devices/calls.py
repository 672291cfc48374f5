# SPDX-License-Identifier: BSD-3-Clause
"""Which calls follow what was said, and which undo them at a stop."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass
from typing import Final

from voice_assist.config.devices import DeviceCallConfig, DevicesConfig

MAX_WAITING: Final = 5  # calls; of more the newest are refused


@dataclass(frozen=True)
class CallResult:
    """What came of a call, in words for people."""

    call: DeviceCallConfig
    is_done: bool
    words: str


class DeviceCalls:
    """Calls that wait to be made; commands and stops come from several threads.

    Args:
        config: The allow-list.
    """

    def __init__(self, config: DevicesConfig) -> None:
        self._config, self._changed = config, threading.Condition()
        self._waiting: deque[DeviceCallConfig] = deque()
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
            self._changed.notify()
        return None

    def next(self, timeout: float) -> DeviceCallConfig | None:
        """The call to be made now, which counts as made; None: none came in time.

        Args:
            timeout: How long to wait for one [s].
        """
        with self._changed:
            if not self._changed.wait_for(lambda: self._waiting, timeout):
                return None
            call = self._waiting.popleft()
            self._undone_by = {p: u for p, u in self._undone_by.items() if u != call.phrase}
            # From its beginning on: whether a call that failed had an effect is not known.
            if call.on_stop:
                self._undone_by[call.phrase] = call.on_stop
        return call

    def stopped(self) -> tuple[CallResult, ...]:
        """Drop what waits, and let what undoes the calls that were made wait instead.

        Several messages may report one stop. So what undoes a call stays until it is made itself.

        Returns:
            What is dropped.
        """
        with self._changed:
            undoing = list(dict.fromkeys(reversed(self._undone_by.values())))  # newest first
            dropped = [call for call in self._waiting if call.phrase not in undoing]
            self._waiting = deque(call for p in undoing if (call := self._config.get(p)))
            self._changed.notify()
        return tuple(CallResult(call, False, "dropped by a stop") for call in dropped)
