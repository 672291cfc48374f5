# SPDX-License-Identifier: BSD-3-Clause
"""Exact one-sided bounds on a share and on a rate."""

from __future__ import annotations

from scipy.stats import beta, chi2

SURE = 0.95  # of each bound


def at_least(count: int, trials: int) -> float:
    """Lower bound on the share behind `count` of `trials` (Clopper and Pearson 1934)."""
    return float(beta.ppf(1.0 - SURE, count, trials - count + 1)) if count else 0.0


def at_most(count: int, trials: int) -> float:
    """Upper bound on the share behind `count` of `trials` (Clopper and Pearson 1934)."""
    return float(beta.ppf(SURE, count + 1, trials - count)) if count < trials else 1.0


def rate_at_most(count: int, hours: float) -> float:
    """Upper bound on the rate behind so many events in a time [1/h] (Garwood 1936).

    Args:
        count: Events, taken as a Poisson process.
        hours: Watched, above 0 [h].
    """
    return float(chi2.ppf(SURE, 2 * count + 2)) / (2.0 * hours)
