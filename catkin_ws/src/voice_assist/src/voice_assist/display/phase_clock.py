# SPDX-License-Identifier: BSD-3-Clause
"""How long a phase will still take, by how fast it went lately."""

from __future__ import annotations

from collections import deque

WINDOW = 1.0  # [s] of progress that counts
_SHORTEST = 0.2  # [s] of it, at least
_LONGEST = 100.0  # [s] that is still worth saying


class PhaseClock:
    """Follows the progress of one phase after the other."""

    def __init__(self) -> None:
        self._phase = ""
        self._seen: deque[tuple[float, float]] = deque()  # time [s], progress

    def report(self, phase: str, progress: float, now: float) -> None:
        """Note how far a phase is.

        Args:
            phase: Its name.
            progress: From 0 to 1; one that falls begins anew.
            now: Steady clock [s].
        """
        if phase != self._phase or (self._seen and progress < self._seen[-1][1]):
            self._phase = phase
            self._seen.clear()
        self._seen.append((now, progress))
        while now - self._seen[0][0] > WINDOW:
            self._seen.popleft()

    @property
    def remaining(self) -> float | None:
        """Time to the end at the mean speed of the window [s]; None: too little is known."""
        if not self._seen:
            return None
        (began, first), (now, last) = self._seen[0], self._seen[-1]
        if now - began < _SHORTEST or last <= first or not first <= last < 1.0:
            return None
        remaining = (1.0 - last) * (now - began) / (last - first)
        return remaining if remaining <= _LONGEST else None
