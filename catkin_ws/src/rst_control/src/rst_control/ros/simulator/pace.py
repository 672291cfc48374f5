# SPDX-License-Identifier: BSD-3-Clause
"""Keeps simulated time in step with the clock, and keeps count of how well."""

from __future__ import annotations

from collections.abc import Callable


class SimulationPace:
    """Says when the next period is due; lateness is made up for by periods without a pause.

    Args:
        period: Simulated time of one period [s].
        factor: Simulated over real time [-]; 0: never waits.
        clock: Real time [s].
        sleep: Waits so many seconds.
    """

    def __init__(
        self,
        period: float,
        factor: float,
        clock: Callable[[], float],
        sleep: Callable[[float], None],
    ) -> None:
        self._period = period / factor if factor > 0.0 else 0.0
        self._clock, self._sleep = clock, sleep
        self._due = clock()
        self.periods = self.late = 0  # so far; those of them that began half a period late or more
        self.given_up = 0.0  # [s] of lateness that was not made up for

    def start(self) -> None:
        """Count from now on."""
        self._due = self._clock()

    def wait(self) -> float:
        """Wait until the next period is due.

        Returns:
            How late it is then [s].
        """
        self.periods += 1
        if self._period == 0.0:
            return 0.0
        self._due += self._period
        # of no length, too: a loop in real time that never sleeps lets no thread of its own receive
        self._sleep(max(self._due - self._clock(), 0.0))
        behind = self._clock() - self._due
        self.late += behind > 0.5 * self._period
        return behind

    def give_up(self, behind: float) -> None:
        """Count from now on; what was lost is not made up for."""
        self._due += behind
        self.given_up += behind
