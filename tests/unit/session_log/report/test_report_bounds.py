# SPDX-License-Identifier: BSD-3-Clause
"""Confidence bounds against published values and against their own promise."""

import math

import numpy as np
import pytest
from scipy.stats import binom

from session_log.report.bounds import at_least, at_most, proportion, quantile


@pytest.mark.parametrize(
    ("hits", "trials", "low", "high"),
    [
        (586, 586, 0.9937, 1.0),  # the HERMES count: at least 99.4 % by the two-sided bound
        (0, 10, 0.0, 0.3085),
        (5, 10, 0.1871, 0.8129),
        (81, 263, 0.2527, 0.3676),  # Newcombe, Statistics in Medicine 17, 1998, table I, method 5
    ],
)
def test_proportions_agree_with_published_bounds(hits, trials, low, high):
    found = proportion(hits, trials)
    assert (found.low, found.high) == pytest.approx((low, high), abs=1e-4)
    assert found.value == hits / trials


def test_no_trials_say_nothing():
    found = proportion(0, 0)
    assert math.isnan(found.value) and (found.low, found.high) == (0.0, 1.0)


def test_more_hits_than_trials_are_refused():
    with pytest.raises(ValueError, match="3 hits in 2 trials"):
        proportion(3, 2)


@pytest.mark.parametrize(("p", "least"), [(0.5, 6), (0.95, 72)])
def test_a_quantile_needs_a_number_of_values_for_both_bounds(p, least):
    few, enough = quantile(range(least - 1), p), quantile(range(least), p)
    assert math.isnan(few.low) or math.isnan(few.high)
    assert enough.low < enough.value <= enough.high


@pytest.mark.parametrize(("p", "n"), [(0.5, 11), (0.5, 60), (0.95, 100), (0.95, 400)])
def test_the_bounds_of_a_quantile_hold_as_often_as_they_promise(p, n):
    """Ranks of the bounds: the true quantile lies between them with at least 95 %, exactly."""
    found = quantile(np.arange(1, n + 1), p)
    low, high = int(found.low), int(found.high)  # ranks, because value k has rank k
    held = binom.cdf(high - 1, n, p) - binom.cdf(low - 1, n, p)
    assert held >= 0.95


def test_no_values_have_no_quantile():
    assert math.isnan(quantile([], 0.5).value)


@pytest.mark.parametrize(("hits", "trials"), [(0, 60), (3, 96), (110, 112), (7, 7)])
def test_a_one_sided_bound_leaves_five_percent_on_its_side(hits, trials):
    if hits:
        assert binom.sf(hits - 1, trials, at_least(hits, trials)) == pytest.approx(0.05)
    if hits < trials:
        assert binom.cdf(hits, trials, at_most(hits, trials)) == pytest.approx(0.05)


def test_one_sided_bounds_reach_the_ends_only_where_nothing_speaks_against_it():
    assert at_least(0, 50) == 0.0 and at_most(50, 50) == 1.0
    assert at_most(0, 3000) == pytest.approx(1 - 0.05 ** (1 / 3000))
