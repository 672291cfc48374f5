# SPDX-License-Identifier: BSD-3-Clause
"""Messages that come late, by a delay and a jitter."""

from __future__ import annotations

from collections import deque
from typing import Generic, TypeVar

import numpy as np

Item = TypeVar("Item")


class LateQueue(Generic[Item]):
    """Hands over what was put in after a delay and a jitter, in the order in which it came.

    Args:
        delay: [s].
        jitter: Of more delay, at most; drawn evenly [s].
        random: Of the jitter.
    """

    def __init__(self, delay: float, jitter: float, random: np.random.Generator) -> None:
        self._delay, self._jitter, self._random = delay, jitter, random
        self._waiting: deque[tuple[float, Item]] = deque()

    def put(self, item: Item, now: float) -> None:
        """Send something at a time [s]; it does not overtake what was sent before."""
        due = now + self._delay + self._jitter * float(self._random.uniform())
        if self._waiting:
            due = max(due, self._waiting[-1][0])
        self._waiting.append((due, item))

    def take(self, now: float) -> list[Item]:
        """All that has arrived by a time [s], oldest first."""
        found = []
        while self._waiting and self._waiting[0][0] <= now:
            found.append(self._waiting.popleft()[1])
        return found
