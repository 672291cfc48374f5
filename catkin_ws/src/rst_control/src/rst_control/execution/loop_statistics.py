# SPDX-License-Identifier: BSD-3-Clause
"""Counts late ticks of the control loop and keeps the last tick times, without allocating."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

KEPT = 5000  # ticks: ten seconds at 500 Hz


@dataclass(frozen=True)
class LoopSummary:
    """How the loop kept its times: totals since the start, percentiles over the ticks kept."""

    ticks: int
    late: int
    skipped: int  # periods in which no tick ran at all
    duration_p50: float  # [s]
    duration_p99: float  # [s]
    lateness_p99: float  # [s]

    @property
    def late_percent(self) -> float:
        """Share of the ticks that came late, skipped ones included [%]."""
        return 100.0 * (self.late + self.skipped) / max(1, self.ticks + self.skipped)


class LoopStatistics:
    """Written by the loop's thread alone; `summary` may be called from another."""

    def __init__(self, late_after: float) -> None:
        """Count a tick as late that begins more than `late_after` seconds behind its time."""
        self._late_after = late_after
        self._ticks = 0
        self._late = 0
        self._skipped = 0
        self._duration = np.zeros(KEPT)
        self._lateness = np.zeros(KEPT)

    def record(self, lateness: float, duration: float) -> None:
        """Add one tick.

        Args:
            lateness: How long after its time it began [s].
            duration: How long it took [s].
        """
        slot = self._ticks % KEPT
        self._lateness[slot] = lateness
        self._duration[slot] = duration
        self._ticks += 1
        if lateness > self._late_after:
            self._late += 1

    def skip(self, periods: int) -> None:
        """Add periods that passed without a tick."""
        self._skipped += periods

    def summary(self) -> LoopSummary:
        """How the loop has kept its times until now."""
        filled = min(self._ticks, KEPT)
        if filled == 0:
            return LoopSummary(0, 0, self._skipped, 0.0, 0.0, 0.0)
        p50, p99 = np.percentile(self._duration[:filled], (50, 99))
        return LoopSummary(
            self._ticks,
            self._late,
            self._skipped,
            float(p50),
            float(p99),
            float(np.percentile(self._lateness[:filled], 99)),
        )
