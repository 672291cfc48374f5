# SPDX-License-Identifier: BSD-3-Clause
"""Shows what the alarm node says, and that nobody watches where it is gone or hangs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

SILENT = 3.5  # [s] without the status that the alarm node publishes once a second: it hangs

Word = TypeVar("Word")


class AlarmWatch(Generic[Word]):
    """Follows the alarm node, which publishes an alarm on change only.

    Args:
        show: Gets what stands first; None while nobody watches.
        is_connected: Whether a node that publishes alarms is there.
        clock: Steady clock [s].
    """

    def __init__(
        self,
        show: Callable[[Word | None], None],
        is_connected: Callable[[], bool],
        clock: Callable[[], float],
    ) -> None:
        self._show, self._is_connected, self._clock = show, is_connected, clock
        self._lock = threading.Lock()  # or a loss could be shown after the word of a new node
        self._word: Word | None = None
        self._node = ""  # that said it
        self._heard = clock()  # [s] when it said or published anything

    def see_alarm(self, word: Word, node: str) -> None:
        """What stands first, and the name of the node that says so."""
        with self._lock:
            self._word, self._node, self._heard = word, node, self._clock()
            self._show(word)

    def see_status(self, node: str) -> None:
        """A node published diagnostics."""
        with self._lock:
            if node == self._node:
                self._heard = self._clock()

    def look_again(self) -> None:
        """Notice that the node is gone or hangs, or works again."""
        with self._lock:
            if not self._is_connected():
                self._word = None
            is_silent = self._clock() - self._heard > SILENT
            self._show(None if is_silent else self._word)
