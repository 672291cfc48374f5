# SPDX-License-Identifier: BSD-3-Clause
"""Exact bounds on a share and on a rate, from counts."""

from __future__ import annotations

from scipy.stats import binomtest, chi2

CONFIDENCE = 0.95  # of each bound, and of an interval


def share_interval(count: int, trials: int) -> tuple[float, float]:
    """Two-sided interval of the share behind `count` of `trials` (Clopper and Pearson 1934)."""
    if not trials:
        return 0.0, 1.0
    interval = binomtest(count, trials).proportion_ci(CONFIDENCE, "exact")
    return float(interval.low), float(interval.high)


def share_at_most(count: int, trials: int) -> float:
    """Upper bound on the share behind `count` of `trials` (Clopper and Pearson 1934)."""
    if not trials:
        return 1.0
    test = binomtest(count, trials, alternative="less")
    return float(test.proportion_ci(CONFIDENCE, "exact").high)


def rate_at_most(count: int, hours: float) -> float:
    """Upper bound on the rate [1/h] of events, a Poisson process (Garwood 1936).

    Args:
        count: Events.
        hours: Watched [h]; 0: nothing is known, and the bound is infinite.
    """
    return (
        float(chi2.ppf(CONFIDENCE, 2 * count + 2)) / (2.0 * hours) if hours > 0.0 else float("inf")
    )
