# SPDX-License-Identifier: BSD-3-Clause
"""Exact confidence bounds of proportions and quantiles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binomtest, quantile_test

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Bounded:
    """An estimate and its 95 % confidence interval; a bound that the data cannot give is nan."""

    value: float
    low: float
    high: float


def proportion(hits: int, trials: int) -> Bounded:
    """Share of hits with Clopper and Pearson's exact bounds (Biometrika 26, 1934).

    Raises:
        ValueError: There are fewer trials than hits.
    """
    if hits > trials:
        raise ValueError(f"{hits} hits in {trials} trials")
    if trials == 0:
        return Bounded(math.nan, 0.0, 1.0)
    each = 0.5 * (1.0 + CONFIDENCE)
    return Bounded(hits / trials, at_least(hits, trials, each), at_most(hits, trials, each))


def at_least(hits: int, trials: int, confidence: float = CONFIDENCE) -> float:
    """One-sided lower bound of a share (Clopper and Pearson 1934).

    Args:
        hits: Out of the trials.
        trials: At least one.
        confidence: That the share is not below it, in (0, 1).
    """
    test = binomtest(hits, trials, alternative="greater")
    return float(test.proportion_ci(confidence, "exact").low)


def at_most(hits: int, trials: int, confidence: float = CONFIDENCE) -> float:
    """One-sided upper bound of a share (Clopper and Pearson 1934).

    Args:
        hits: Out of the trials.
        trials: At least one.
        confidence: That the share is not above it, in (0, 1).
    """
    test = binomtest(hits, trials, alternative="less")
    return float(test.proportion_ci(confidence, "exact").high)


def quantile(values: Sequence[float], p: float) -> Bounded:
    """Quantile with distribution-free bounds from order statistics.

    Conover, Practical Nonparametric Statistics, 3rd edition, section 3.2. Few values leave a
    bound open: a median needs 6, a 95th percentile 72 for an upper bound.

    Args:
        values: At least one, finite.
        p: Which quantile, in (0, 1).
    """
    x = np.sort(np.asarray(values, dtype=float))
    if not len(x):
        return Bounded(math.nan, math.nan, math.nan)
    bounds = quantile_test(x, q=float(np.quantile(x, p)), p=p).confidence_interval(CONFIDENCE)
    return Bounded(float(np.quantile(x, p)), float(bounds.low), float(bounds.high))
