# SPDX-License-Identifier: BSD-3-Clause
"""When to publish: at a rate; or at each change, and again now and then.

Should anybody else have spoken in the robot's name, the truth comes back by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from operator import eq
from typing import Generic, TypeVar

T = TypeVar("T")
ROUNDING = 1e-9  # [s] of a time that is a multiple of the period


class Repeated(Generic[T]):
    """Remembers what was published last, and when.

    Args:
        period: After which the same is published again [s].
        are_alike: Whether the second of two values is no news after the first.
    """

    def __init__(self, period: float, are_alike: Callable[[T, T], bool] = eq) -> None:
        self._period, self._are_alike = period, are_alike
        self.last: T | None = None  # published; None: nothing yet
        self._published_at = 0.0

    def is_due(self, value: T, now: float) -> bool:
        """Whether the value has to be published at a time [s]; if so, it counts as published."""
        is_news = self.last is None or not self._are_alike(self.last, value)
        if not is_news and now - self._published_at < self._period:
            return False
        self.last, self._published_at = value, now
        return True


class Due:
    """Says when something that is done at a rate is due; what was missed is not made up for.

    Args:
        period: Of the rate [s].
    """

    def __init__(self, period: float) -> None:
        self._period, self._next = period, 0.0

    def __call__(self, now: float) -> bool:
        """Whether it is due at a time [s]; if so, it counts as done."""
        if now + ROUNDING < self._next:
            return False
        self._next = max(self._next + self._period, now)
        return True
