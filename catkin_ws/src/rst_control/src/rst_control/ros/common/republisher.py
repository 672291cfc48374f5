# SPDX-License-Identifier: BSD-3-Clause
"""What is published at each change, and again now and then.

Should anybody else have spoken in the robot's name, the truth comes back by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from operator import eq
from typing import Generic, TypeVar

T = TypeVar("T")


class Repeated(Generic[T]):
    """Remembers what was published last, and when.

    Args:
        period: After which the same is published again [s].
        are_alike: Whether the second of two values is no news after the first.
    """

    def __init__(self, period: float, are_alike: Callable[[T, T], bool] = eq) -> None:
        self._period, self._are_alike = period, are_alike
        self.last: T | None = None  # published; None: nothing yet
        self._told_at = 0.0

    def is_due(self, value: T, now: float) -> bool:
        """Whether the value has to be published at a time [s]; if so, it counts as published."""
        is_news = self.last is None or not self._are_alike(self.last, value)
        if not is_news and now - self._told_at < self._period:
            return False
        self.last, self._told_at = value, now
        return True
