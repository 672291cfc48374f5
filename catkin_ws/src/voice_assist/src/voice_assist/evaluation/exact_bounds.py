# SPDX-License-Identifier: BSD-3-Clause
"""Exact bounds on a share and on a rate, from counts."""

from __future__ import annotations

from scipy.stats import beta, chi2

CONFIDENCE = 0.95  # of each bound, and of an interval


def share_interval(count: int, trials: int) -> tuple[float, float]:
    """Two-sided interval of the share behind `count` of `trials` (Clopper and Pearson 1934)."""
    tail = (1 - CONFIDENCE) / 2
    low = float(beta.ppf(tail, count, trials - count + 1)) if count else 0.0
    high = float(beta.ppf(1 - tail, count + 1, trials - count)) if count < trials else 1.0
    return low, high


def share_at_most(count: int, trials: int) -> float:
    """Upper bound on the share behind `count` of `trials` (Clopper and Pearson 1934)."""
    return float(beta.ppf(CONFIDENCE, count + 1, trials - count)) if count < trials else 1.0


def rate_at_most(count: int, hours: float) -> float:
    """Upper bound on the rate [1/h] of events, a Poisson process (Garwood 1936).

    Args:
        count: Events.
        hours: Watched [h]; 0: nothing is known, and the bound is infinite.
    """
    return (
        float(chi2.ppf(CONFIDENCE, 2 * count + 2)) / (2.0 * hours) if hours > 0.0 else float("inf")
    )
