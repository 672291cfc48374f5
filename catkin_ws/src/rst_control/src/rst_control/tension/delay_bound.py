# SPDX-License-Identifier: BSD-3-Clause
"""Upper bound on the tension that the sensor has not reported yet: its delay times the rate."""

from __future__ import annotations

from collections import deque


class DelayBound:
    """Keeps the tension as far back as it is late.

    A measurement that is late by a delay misses the rate times the delay. What it rose by within
    the last delay is expected of the present one, too.

    Args:
        delay: By which the measured tension is late [s].
    """

    def __init__(self, delay: float) -> None:
        self._delay = delay
        self._past: deque[tuple[float, float]] = deque()

    def update(self, stamp: float, tension: float) -> None:
        """Take in a measured tension [N] at a time [s]; one that is no newer is passed over."""
        if self._past and stamp <= self._past[-1][0]:
            return
        self._past.append((stamp, tension))
        while len(self._past) > 1 and self._past[1][0] <= stamp - self._delay:
            self._past.popleft()

    def forget(self) -> None:
        """Begin anew, as after a tension that was not trusted: from it to the next nothing rose."""
        self._past.clear()

    @property
    def ahead(self) -> float:
        """What has to be added to the newest tension [N]; where it falls, nothing."""
        if self._delay <= 0.0 or len(self._past) < 2:
            return 0.0
        (since, first), (now, last) = self._past[0], self._past[-1]
        return max(0.0, last - first) * min(1.0, self._delay / (now - since))
