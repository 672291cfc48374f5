# SPDX-License-Identifier: BSD-3-Clause
"""Random paths keep the trocar everywhere, as seen by an independent kinematics."""

import numpy as np
import pytest

from bench.motion.paths import by_kdl, random_paths, shaft_error
from rst_control.trajectory.path import speed_bounds
from support.kdl_chain import Kdl

PATHS = 60
TOLERANCE = 1e-6  # [m]
DENSER = 10


@pytest.fixture(scope="module")
def legs(planner):
    """Legs between random tool poses in the workspace, one after the other."""
    return list(random_paths(planner, PATHS, seed=3))


def test_the_shaft_stays_in_the_trocar_at_and_between_knots(planner, legs):
    shaft, worst = by_kdl(planner.model), 0.0
    for path, _ in legs:
        for s in np.linspace(0.0, path.length, DENSER * (len(path.knots) - 1) + 1):
            worst = max(worst, shaft_error(shaft(path.evaluate(s).q), planner.trocar))
    assert worst < TOLERANCE


def test_the_tip_goes_straight_at_the_pace_of_s_to_its_goal(planner, legs):
    kdl = Kdl(planner.model, "tool_tip")
    for path, goal in legs:
        start, end = kdl.frame(path.start)[:3, 3], goal[:3, 3]
        for share in np.linspace(0.0, 1.0, 23):
            tip = kdl.frame(path.evaluate(share * path.length).q)[:3, 3]
            np.testing.assert_allclose(tip, start + share * (end - start), atol=TOLERANCE)


def test_curvature_does_not_jump_at_knots(legs):
    for path, _ in legs:
        largest = np.abs(path.evaluate(0.5 * path.length).ddq).max() + 1.0
        for knot in range(1, len(path.knots) - 1):
            before = path.evaluate(knot * path.spacing - 1e-9).ddq
            after = path.evaluate(knot * path.spacing + 1e-9).ddq
            assert np.abs(after - before).max() < 0.05 * largest


def test_no_joint_exceeds_its_limits_at_the_speed_a_path_allows(planner, legs):
    for path, _ in legs:
        samples = path.sample(planner.model.chain, planner.trocar)
        speed, acceleration = speed_bounds(samples, planner.limits, 10.0, 5.0)
        assert speed < 10.0 and speed_bounds(samples, planner.limits, 0.001, 5.0)[0] == 0.001
        rate, bend = np.abs(samples.q[:, 1]), np.abs(samples.q[:, 2])
        assert (rate * speed <= planner.limits.velocity * (1 + 1e-9)).all()
        hardest = rate * acceleration + bend * speed**2
        assert (hardest <= planner.limits.acceleration * (1 + 1e-9)).all()
        planner.limits.require(samples.q[:, 0].min(axis=0))
        planner.limits.require(samples.q[:, 0].max(axis=0))
