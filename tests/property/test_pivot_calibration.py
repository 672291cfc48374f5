# SPDX-License-Identifier: BSD-3-Clause
"""Properties of the point that recorded shafts have in common."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rst_control.kinematics.rcm import rcm_error_vector
from rst_control.kinematics.robot_model import rotation
from rst_control.registration.pivot_calibration import TooLittleSpread, fit_pivot

STEP = 1e-6  # [m] of finite differences
TILT = 0.3  # [rad] of the shafts that are drawn, at most

seeds = st.integers(0, 2**32 - 1)
counts = st.integers(5, 30)
coordinates = st.floats(-1.0, 1.0)
points = st.tuples(coordinates, coordinates, coordinates).map(np.array)


def shafts(seed, count, trocar, noise=0.0):
    """Shafts that go through a trocar at any depth, each moved aside by noise [m] per axis."""
    rng = np.random.default_rng(seed)
    tilt, turn = rng.uniform(0.1, TILT, count), np.linspace(0.0, 2.0 * np.pi, count, False)
    common = rotation(rng.uniform(-1.5, 1.5, 3))
    d = np.column_stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    d = d @ common.T
    a = trocar - rng.uniform(0.05, 0.25, (count, 1)) * d + rng.normal(0.0, noise, (count, 3))
    return a, d


def fit(a, d):
    return fit_pivot(a, d, 3, 0.01)


@given(seeds, counts, points)
def test_lines_through_a_point_give_back_that_point(seed, count, trocar):
    result = fit(*shafts(seed, count, trocar))
    assert_allclose(result.position, trocar, atol=1e-11)
    assert result.largest < 1e-11 and result.deviation < 1e-10
    assert result.outliers == ()


@given(seeds, counts, points, st.tuples(*[st.floats(-3.0, 3.0)] * 3), points)
def test_moving_everything_moves_the_point_and_nothing_else(seed, count, trocar, turn, shift):
    a, d = shafts(seed, count, trocar, noise=1e-3)
    R, here = rotation(turn), fit(a, d)
    there = fit(a @ R.T + shift, d @ R.T)
    assert_allclose(there.position, R @ here.position + shift, atol=1e-9)
    assert_allclose(there.residuals, here.residuals, atol=1e-9)
    assert_allclose(there.covariance, R @ here.covariance @ R.T, atol=1e-12)
    assert there.spread == pytest.approx(here.spread)


@given(seeds, counts, points)
def test_at_the_fit_the_sum_of_squares_is_at_its_least(seed, count, trocar):
    """Of distances to whole lines: where along its shaft a pose was recorded plays no part."""
    a, d = shafts(seed, count, trocar, noise=1e-3)

    def squares(p):
        return sum(float(np.sum(rcm_error_vector(x, y, p) ** 2)) for x, y in zip(a, d, strict=True))

    result = fit(a, d)
    assert squares(result.position) == pytest.approx(float(np.sum(result.residuals**2)), rel=1e-6)
    for axis in np.eye(3):
        ahead = squares(result.position + STEP * axis)
        behind = squares(result.position - STEP * axis)
        assert abs(ahead - behind) / (2.0 * STEP) < 1e-7 * count
        assert ahead + behind > 2.0 * squares(result.position)


@settings(max_examples=6)
@given(seeds, st.sampled_from([1e-5, 1e-4, 1e-3]))
def test_the_error_is_as_large_as_the_covariance_says(seed, noise):
    """Over many repetitions: errors in units of the expected deviation have mean square one."""
    trocar, errors, known = np.array([0.4, 0.0, 0.4]), [], []
    for repetition in range(120):
        a, d = shafts(seed, 12, trocar)
        rng = np.random.default_rng([seed, repetition])
        result = fit(a + rng.normal(0.0, noise, a.shape), d)
        errors.append(result.position - trocar)
        known.append(result.covariance)
    seen = np.cov(np.array(errors).T)
    expected = np.mean(known, axis=0)
    values, axes = np.linalg.eigh(expected)
    ratios = np.diag(axes.T @ seen @ axes) / values
    assert ((ratios > 0.5) & (ratios < 1.7)).all()


@given(seeds, points, st.integers(2, 6))
def test_more_noise_means_more_residual_in_proportion(seed, trocar, times):
    a, d = shafts(seed, 12, trocar)
    noise = np.random.default_rng(seed).normal(0.0, 1e-4, a.shape)
    one, more = fit(a + noise, d), fit(a + times * noise, d)
    assert_allclose(more.position - trocar, times * (one.position - trocar), atol=1e-10)
    assert more.rms == pytest.approx(times * one.rms, rel=1e-6)
    assert more.deviation == pytest.approx(times * one.deviation, rel=1e-6)


@given(seeds, counts, points, points, st.sampled_from([0.0, 0.01]))
def test_parallel_shafts_are_refused(seed, count, trocar, direction, width):
    length = float(np.linalg.norm(direction))
    d = direction / length if length > 0.05 else np.array([0.0, 0.0, 1.0])
    aside = np.random.default_rng(seed).normal(0.0, width, (count, 3))
    with pytest.raises(TooLittleSpread):
        fit_pivot(trocar + aside, np.tile(d, (count, 1)), 3, 0.0)
