# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from rst_control.registration.pivot_calibration import (
    PivotIllPosed,
    TooFewPoses,
    TooLittleSpread,
    fit_pivot,
)

TROCAR = np.array([0.406, -0.024, 0.415])


def lines(tilts):
    """Shafts through the trocar, tilted so much [rad] all the way round."""
    points, directions = [], []
    for n, tilt in enumerate(tilts):
        turn = 2.4 * n
        d = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), -np.cos(tilt)])
        points.append(TROCAR - 0.15 * d)
        directions.append(d)
    return np.array(points), np.array(directions)


def fit(points, directions, min_poses=3, min_spread=0.02):
    return fit_pivot(points, directions, min_poses, min_spread)


def test_the_spread_is_the_rms_angle_from_the_common_direction():
    assert fit(*lines([0.2] * 60)).spread == pytest.approx(0.2, abs=0.01)


def test_lines_beside_the_trocar_leave_their_distance_as_residual():
    points, directions = lines([0.3, 0.3, 0.3, 0.3])
    up = np.array([0.0, 0.0, 1e-3])
    both = np.vstack([points + up, points - up])
    result = fit(both, np.vstack([directions, directions]))
    np.testing.assert_allclose(result.position, TROCAR, atol=1e-9)
    np.testing.assert_allclose(result.residuals, 1e-3 * np.sin(0.3), rtol=1e-6)
    assert result.rms == pytest.approx(result.largest)


def test_too_few_poses_are_refused_with_both_numbers():
    with pytest.raises(TooFewPoses, match="3 shaft poses recorded, allowed 5 and more"):
        fit(*lines([0.2] * 3), min_poses=5)
    with pytest.raises(TooFewPoses, match="0 shaft poses recorded, allowed 5"):
        fit([], [], min_poses=5)


def test_shafts_that_point_the_same_way_are_refused_with_both_angles():
    with pytest.raises(TooLittleSpread, match=r"by 0\.57 deg rms, allowed 2\.86 deg and more") as e:
        fit(*lines([0.01] * 30), min_spread=0.05)
    assert e.value.spread == pytest.approx(0.01, abs=1e-3)
    assert isinstance(e.value, PivotIllPosed)


def test_poses_that_contradict_the_others_are_named():
    points, directions = lines([0.25] * 10)
    rng = np.random.default_rng(1)
    points = points + rng.normal(0.0, 1e-4, points.shape)
    points[[2, 7]] += [[0.0, 0.008, 0.0], [0.006, 0.0, 0.0]]
    assert fit(points, directions).outliers == (2, 7)


def test_ordinary_noise_makes_no_outliers():
    points, directions = lines([0.25] * 10)
    points = points + np.random.default_rng(2).normal(0.0, 1e-3, points.shape)
    assert fit(points, directions).outliers == ()


def test_a_direction_counts_whatever_its_length_but_zero_is_refused():
    points, directions = lines([0.2] * 5)
    doubled = fit(points, directions * [[1.0], [2.0], [-3.0], [0.1], [5.0]])
    np.testing.assert_allclose(doubled.position, fit(points, directions).position, atol=1e-12)
    directions[3] = 0.0
    with pytest.raises(ValueError, match="direction 3 has no length"):
        fit(points, directions)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_values_that_are_not_finite_are_refused(bad):
    points, directions = lines([0.2] * 5)
    points[1, 2] = bad
    with pytest.raises(ValueError, match="not finite"):
        fit(points, directions)
