# SPDX-License-Identifier: BSD-3-Clause
"""Exact confidence bounds of proportions and quantiles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import bdtr, betaincinv

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
        raise ValueError(f"{hits} hits in {trials} trials, allowed: 0 to {trials}")
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
    return float(betaincinv(hits, trials - hits + 1, 1.0 - confidence)) if hits else 0.0


def at_most(hits: int, trials: int, confidence: float = CONFIDENCE) -> float:
    """One-sided upper bound of a share (Clopper and Pearson 1934).

    Args:
        hits: Out of the trials.
        trials: At least one.
        confidence: That the share is not above it, in (0, 1).
    """
    return float(betaincinv(hits + 1, trials - hits, confidence)) if hits < trials else 1.0


def quantile(values: Sequence[float], p: float) -> Bounded:
    """Quantile with distribution-free bounds from order statistics.

    Conover, Practical Nonparametric Statistics, 3rd edition, section 3.2. Few values leave a
    bound open: a median needs 6, a 95th percentile 72 for an upper bound.

    Args:
        values: Finite; none give nan.
        p: Which quantile, in (0, 1).
    """
    x = np.sort(np.asarray(values, dtype=float))
    if not len(x):
        return Bounded(math.nan, math.nan, math.nan)
    below = bdtr(np.arange(len(x) + 1), len(x), p)  # that so many values or fewer are below it
    side = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.searchsorted(below, (side, 1.0 - side))
    return Bounded(
        float(np.quantile(x, p)),
        float(x[low - 1]) if low else math.nan,
        float(x[high]) if high < len(x) else math.nan,
    )
