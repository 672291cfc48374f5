# SPDX-License-Identifier: BSD-3-Clause
"""Calls of this node that the controller's state may not show yet."""

from __future__ import annotations

from threading import Lock


class UnansweredCalls:
    """Counts them; called from several threads. All times are of one steady clock [s].

    Args:
        settle: Time after an answer in which a state from before it may still come [s].
    """

    def __init__(self, settle: float) -> None:
        self._settle, self._lock = settle, Lock()
        self._count, self._settled_at = 0, float("-inf")

    def send(self) -> None:
        """A call is about to be sent."""
        with self._lock:
            self._count += 1

    def answer(self, now: float) -> None:
        """The controller answered a call, or failed to."""
        with self._lock:
            self._count = max(self._count - 1, 0)
            self._settled_at = now + self._settle

    def drop(self, now: float) -> None:
        """Calls that wait to be sent never will be; one that was sent may still have an effect."""
        with self._lock:
            if self._count:
                self._count, self._settled_at = 0, now + self._settle

    def are_settled(self, now: float) -> bool:
        """Whether the newest state shows what all of them led to."""
        with self._lock:
            return self._count == 0 and now >= self._settled_at
