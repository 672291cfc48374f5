# SPDX-License-Identifier: BSD-3-Clause
"""Random paths keep the trocar everywhere, as seen by an independent kinematics."""

import numpy as np
import PyKDL
import pytest

from rst_control.errors import Infeasible
from rst_control.kinematics.rcm import rcm_error_vector
from rst_control.kinematics.robot_model import rotation
from rst_control.trajectory.path import speed_bounds
from support.kdl_chain import kdl_chain

PATHS = 60
TOLERANCE = 1e-6  # [m]
DENSER = 10


class Shaft:
    """Shaft frame and tool tip by KDL."""

    def __init__(self, model):
        self._chains = [kdl_chain(model, name) for name in ("interface_link", "tool_tip")]
        self._shaft, self._tip = (PyKDL.ChainFkSolverPos_recursive(c) for c in self._chains)

    def error(self, q, trocar):
        frame = self._frame(self._shaft, q[:7])
        d = np.array(list(frame.M.UnitZ()))
        return float(np.linalg.norm(rcm_error_vector(np.array(list(frame.p)), d, trocar)))

    def tip(self, q):
        return np.array(list(self._frame(self._tip, q).p))

    def _frame(self, solver, q):
        joints, frame = PyKDL.JntArray(len(q)), PyKDL.Frame()
        for i, value in enumerate(q):
            joints[i] = value
        solver.JntToCart(joints, frame)
        return frame


@pytest.fixture(scope="module")
def legs(planner, home):
    """Legs between random tool poses in the workspace, one after the other."""
    rng, paths, q = np.random.default_rng(3), [], home
    while len(paths) < PATHS:
        goal = planner.T_base_grasp.copy()
        goal[:3, :3] = rotation(rng.uniform(-0.3, 0.3, 3)) @ goal[:3, :3]
        goal[:3, 3] = planner.centre + rng.uniform(-0.03, 0.03, 3)
        try:
            paths.append((planner.leg(q, goal), goal))
        except Infeasible:
            q = home
            continue
        q = paths[-1][0].end
    return paths


def test_the_shaft_stays_in_the_trocar_at_and_between_knots(planner, legs):
    shaft, worst = Shaft(planner.model), 0.0
    for path, _ in legs:
        for s in np.linspace(0.0, path.length, DENSER * (len(path.knots) - 1) + 1):
            worst = max(worst, shaft.error(path.evaluate(s).q, planner.trocar))
    assert worst < TOLERANCE


def test_the_tip_goes_straight_at_the_pace_of_s_to_its_goal(planner, legs):
    shaft = Shaft(planner.model)
    for path, goal in legs:
        start, end = shaft.tip(path.start), goal[:3, 3]
        for share in np.linspace(0.0, 1.0, 23):
            tip = shaft.tip(path.evaluate(share * path.length).q)
            np.testing.assert_allclose(tip, start + share * (end - start), atol=TOLERANCE)


def test_derivatives_of_every_path_equal_finite_differences(legs):
    h = 1e-6
    for path, _ in legs:
        for s in np.linspace(2 * h, path.length - 2 * h, 7):
            point, before, after = path.evaluate(s), path.evaluate(s - h), path.evaluate(s + h)
            np.testing.assert_allclose(point.dq, (after.q - before.q) / (2 * h), atol=1e-4)
            np.testing.assert_allclose(point.ddq, (after.dq - before.dq) / (2 * h), atol=1e-1)


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
        speed, acceleration = speed_bounds(samples, planner.limits, 0.2, 5.0)
        rate, bend = np.abs(samples.q[:, 1]), np.abs(samples.q[:, 2])
        assert (rate * speed <= planner.limits.velocity * (1 + 1e-9)).all()
        hardest = rate * acceleration + bend * speed**2
        assert (hardest <= planner.limits.acceleration * (1 + 1e-9)).all()
        planner.limits.require(samples.q[:, 0].min(axis=0))
        planner.limits.require(samples.q[:, 0].max(axis=0))
