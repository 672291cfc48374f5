# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from rst_control.trajectory.path import Path


@pytest.fixture
def cubic():
    """A path whose joints are cubic in s, which Hermite segments meet exactly."""
    s = np.linspace(0.0, 0.3, 4)[:, None]
    factors = np.arange(1.0, 10.0)
    return Path(factors * s**3, 3.0 * factors * s**2, 0.3), factors


def test_a_cubic_is_met_exactly_with_both_derivatives(cubic):
    path, factors = cubic
    for s in np.linspace(0.0, 0.3, 17):
        point = path.evaluate(s)
        np.testing.assert_allclose(point.q, factors * s**3, atol=1e-12)
        np.testing.assert_allclose(point.dq, 3.0 * factors * s**2, atol=1e-11)
        np.testing.assert_allclose(point.ddq, 6.0 * factors * s, atol=1e-10)


def test_beyond_its_ends_a_path_stays_at_them(cubic):
    path, _ = cubic
    np.testing.assert_array_equal(path.evaluate(-1.0).q, path.start)
    np.testing.assert_allclose(path.evaluate(9.0).q, path.end, atol=1e-12)


def test_reversed_twice_is_the_same_and_once_runs_backwards(cubic):
    path, _ = cubic
    back = path.reversed()
    for s in (0.0, 0.07, 0.3):
        there, here = back.evaluate(0.3 - s), path.evaluate(s)
        np.testing.assert_allclose(there.q, here.q, atol=1e-12)
        np.testing.assert_allclose(there.dq, -here.dq, atol=1e-10)
        np.testing.assert_allclose(there.ddq, here.ddq, atol=1e-8)


def test_a_path_keeps_its_own_copy(cubic):
    knots = np.zeros((2, 9))
    path = Path(knots, np.zeros((2, 9)), 1.0)
    knots[:] = 5.0
    assert path.evaluate(0.5).q[0] == 0.0
    assert not path.knots.flags.writeable


def test_samples_hold_every_knot_and_what_lies_between(planner, home):
    path = planner.reach(home)[0]
    samples = path.sample(planner.model.chain, planner.trocar, per_knot=10)
    assert len(samples.s) == 10 * (len(path.knots) - 1) + 1
    np.testing.assert_allclose(samples.q[::10, 0], path.knots, atol=1e-12)
