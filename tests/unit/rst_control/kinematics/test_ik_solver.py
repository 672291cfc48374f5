# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.kinematics import constrained_ik
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.ik_solver import IkSolver
from rst_control.kinematics.rcm import rcm_state


def test_home_is_found_again_from_its_own_tool_pose(planner, home):
    target = Configuration(planner.model, home).T_base_tip
    result = planner.solver.search(target, planner.trocar, home)
    assert result.is_solved
    assert result.iterations == 0
    np.testing.assert_array_equal(result.q, home)


def test_a_settled_pose_has_the_elbow_where_the_posture_is_best(planner, home):
    target = planner.grasp_candidates[0].T_base_tip
    settled = planner.solver.settle(home, target, planner.trocar).q
    other = planner.solver.search(target, planner.trocar, home + 0.05).q
    arm = slice(0, 7)
    assert np.linalg.norm(settled[arm] - home[arm]) <= np.linalg.norm(other[arm] - home[arm]) + 1e-6


def test_joints_that_turn_for_ever_come_out_near_the_reference(planner, home):
    start = home.copy()
    start[[0, 6]] += 2.0 * np.pi
    target = Configuration(planner.model, home).T_base_tip
    result = planner.solver.search(target, planner.trocar, start)
    np.testing.assert_allclose(result.q, home, atol=1e-8)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_no_joint_is_turned_past_its_limit_to_be_nearer_to_its_reference(planner, home, side):
    far, q = home.copy(), home.copy()
    far[0], q[0] = side * 6.0, side * 2.5  # a whole turn further it would be at 8.8 rad
    solver = IkSolver(planner.model, planner.limits, far, planner.config.rcm.solver)
    wrapped = q.copy()
    constrained_ik.wrap(wrapped, solver.posture)
    np.testing.assert_allclose(wrapped, q, atol=1e-12)


def test_the_answer_cannot_be_changed(planner, home):
    result = planner.solver.settle(home, planner.grasp_candidates[0].T_base_tip, planner.trocar)
    with pytest.raises(ValueError, match="read-only"):
        result.q[0] = 0.0


def test_a_narrow_limit_is_kept_by_another_posture(planner, home):
    target = planner.grasp_candidates[0].T_base_tip
    free = planner.solver.settle(home, target, planner.trocar).q
    upper = np.array(planner.limits.upper)
    upper[3] = free[3] - 0.02
    limits = replace(planner.limits, upper=upper)
    solver = IkSolver(planner.model, limits, home, planner.config.rcm.solver)
    result = solver.search(target, planner.trocar, home)
    assert result.is_solved
    assert result.q[3] <= upper[3]
    assert rcm_state(Configuration(planner.model, result.q), planner.trocar).error < 1e-9


def test_more_than_one_start_is_tried_before_giving_up(planner):
    target = np.eye(4)
    target[:3, 3] = [2.0, 0.0, 0.0]
    result = planner.solver.search(target, planner.trocar)
    assert not result.is_solved
    assert result.starts == planner.config.rcm.solver.restarts + 1
    assert result.residual > 0.1 and np.isfinite(result.q).all()
