# SPDX-License-Identifier: BSD-3-Clause
import pytest

from rst_control.execution.loop_statistics import KEPT, LoopStatistics


def test_before_the_first_tick_all_is_zero():
    summary = LoopStatistics(0.001).summary()
    assert summary.ticks == 0 and summary.late_percent == 0.0


def test_late_and_skipped_ticks_are_counted():
    statistics = LoopStatistics(late_after=0.001)
    for lateness in (0.0, 0.0005, 0.0011, 0.5):
        statistics.record(lateness, 1e-4)
    statistics.skip(6)
    summary = statistics.summary()
    assert (summary.ticks, summary.late, summary.skipped) == (4, 2, 6)
    assert summary.late_percent == pytest.approx(80.0)


def test_percentiles_are_of_the_newest_ticks_and_totals_of_all():
    statistics = LoopStatistics(late_after=0.001)
    for _ in range(KEPT):
        statistics.record(0.002, 1.0)
    for _ in range(KEPT):
        statistics.record(0.0, 2e-4)
    summary = statistics.summary()
    assert summary.duration_p50 == summary.duration_p99 == 2e-4
    assert summary.late == KEPT
