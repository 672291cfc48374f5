# SPDX-License-Identifier: BSD-3-Clause
"""Exact bounds on a share and on a rate, from counts."""

from __future__ import annotations

from scipy.special import betaincinv, gammaincinv

CONFIDENCE = 0.95  # of each bound, and of an interval


def share_interval(count: int, trials: int) -> tuple[float, float]:
    """Two-sided interval of the share behind `count` of `trials` (Clopper and Pearson 1934)."""
    if not trials:
        return 0.0, 1.0
    each = 0.5 * (1.0 + CONFIDENCE)
    low = 1.0 - _at_most(trials - count, trials, each)
    return low, _at_most(count, trials, each)


def share_at_most(count: int, trials: int) -> float:
    """Upper bound on the share behind `count` of `trials` (Clopper and Pearson 1934)."""
    return _at_most(count, trials, CONFIDENCE)


def _at_most(count: int, trials: int, confidence: float) -> float:
    if count == trials:
        return 1.0
    return float(betaincinv(count + 1, trials - count, confidence))


def rate_at_most(count: float, hours: float) -> float:
    """Upper bound on the rate [1/h] of events, a Poisson process (Garwood 1936).

    Args:
        count: Events.
        hours: Watched [h]; 0: nothing is known, and the bound is infinite.
    """
    return float(gammaincinv(count + 1, CONFIDENCE)) / hours if hours > 0.0 else float("inf")
