# SPDX-License-Identifier: BSD-3-Clause
"""How much of the tension was lost while nothing moved: tissue relaxes, or the sensor drifts.

Each pull raises the reading again, and hides what was lost before. So the falls add up from the
grasp to the release. A sensor that drifts at rest drifts in motion, too.
"""

from __future__ import annotations


class FallsAtRest:
    """Adds up what mean readings lose from the first to the last of each rest."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Begin anew, with tissue that was just grasped."""
        self._before = self._now = 0.0  # [N] lost in earlier rests, and in this one
        self._first: tuple[float, float] | None = None  # time [s] and mean [N] of this rest
        self._last: float | None = None  # [s] of the newest mean
        self._unseen = 0.0  # [s] from the means before to this rest

    @property
    def total(self) -> float:
        """What was lost since the grasp [N]; tissue that recovers takes it back."""
        return max(0.0, self._before + self._now)

    def move(self) -> None:
        """End a rest."""
        self._before, self._now, self._first = self.total, 0.0, None

    def update(self, first: tuple[float, float], last: tuple[float, float], error: float) -> None:
        """Take in two means of the same rest.

        Args:
            first: Time [s] and mean tension [N].
            last: The same, later.
            error: Of the difference of the means [N].
        """
        if self._first is None:
            self._first = first
            self._unseen = 0.0 if self._last is None else first[0] - self._last
        since, tension = self._first
        lost, self._last = tension - last[1], last[0]
        rate = max(0.0, lost - error) / (last[0] - since)
        self._now = lost + rate * self._unseen
