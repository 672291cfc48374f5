# SPDX-License-Identifier: BSD-3-Clause
"""Inverse kinematics over many targets: what can be reached is found, and found right."""

import numpy as np
import pytest

from bench.site.near_limits import is_right, near_limits
from rst_control.errors import TrocarDrift
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rcm import rcm_state
from rst_control.kinematics.robot_model import rotation

COUNT = 200
NEAR_LIMITS = 40
FEW_STARTS = 20  # of 400; 1,000 poses took up to 7
LEAST_STEEPNESS = 0.3  # cosine of the shaft from straight down
BENCHMARK_TURN = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


@pytest.fixture(scope="module")
def reachable(planner):
    """Joints with the shaft through the trocar: by construction, their tool poses are reachable."""
    rng, found = np.random.default_rng(11), []
    low = np.maximum(planner.limits.lower, -np.pi)
    high = np.minimum(planner.limits.upper, np.pi)
    low[7:], high[7:] = -1.2, 1.2
    while len(found) < COUNT:
        try:
            q = planner.project(rng.uniform(low, high))
        except (TrocarDrift, np.linalg.LinAlgError):
            continue
        turning = planner.limits.upper > np.pi
        q[turning] = (q[turning] + np.pi) % (2.0 * np.pi) - np.pi
        configuration = Configuration(planner.model, q)
        depth = rcm_state(configuration, planner.trocar).insertion
        steepness = -configuration.frames[forward.SHAFT, 2, 2]
        is_inside = planner.limits.violation(q) is None and 0.05 < depth < 0.25
        if is_inside and steepness > LEAST_STEEPNESS:
            found.append(configuration)
    return found


def assert_solved(planner, result, target):
    assert result.is_solved
    planner.limits.require(result.q)
    configuration = Configuration(planner.model, result.q)
    state = rcm_state(configuration, planner.trocar)
    assert state.error < 1e-9
    assert 0.0 < state.insertion < planner.model.shaft_length
    np.testing.assert_allclose(configuration.T_base_tip, target, atol=2e-9)


def test_every_reachable_pose_is_solved_from_cold(planner, reachable):
    for configuration in reachable:
        target = configuration.T_base_tip
        assert_solved(planner, planner.solver.search(target, planner.trocar), target)


def test_poses_with_joints_within_5_mrad_of_their_limits_are_solved_in_few_starts(planner, home):
    poses = [pose for _, pose in near_limits(planner, NEAR_LIMITS, seed=5)]
    results = [planner.solver.search(pose, planner.trocar, home) for pose in poses]
    assert all(is_right(planner, result, pose) for result, pose in zip(results, poses, strict=True))
    assert max(result.starts for result in results) <= FEW_STARTS


def test_the_same_pose_gives_the_same_joints_again(planner, reachable):
    for configuration in reachable[:50]:
        first = planner.solver.search(configuration.T_base_tip, planner.trocar)
        again = planner.solver.search(configuration.T_base_tip, planner.trocar)
        assert (first.q == again.q).all()


def test_the_published_benchmark_circle_is_solved_at_all_points(planner):
    for angle in np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False):
        target = np.eye(4)
        target[:3, :3] = BENCHMARK_TURN
        target[:3, 3] = [
            0.468 + 0.015 * np.cos(angle),
            -0.024 + 0.015 * np.sin(angle),
            0.279,
        ]
        assert_solved(planner, planner.solver.search(target, planner.trocar), target)


def test_settling_gives_one_posture_wherever_it_starts_nearby(planner, home):
    goal = planner.grasp_candidates[0].T_base_tip
    rng = np.random.default_rng(5)
    postures = [
        planner.solver.settle(home + rng.uniform(-0.1, 0.1, 9), goal, planner.trocar).q
        for _ in range(30)
    ]
    np.testing.assert_allclose(postures, np.tile(postures[0], (30, 1)), atol=1e-6)


def test_a_pose_that_only_forbidden_joints_reach_is_not_called_solved(planner, home):
    configuration = Configuration(planner.model, home)
    target = configuration.T_base_tip
    target[:3, :3] = target[:3, :3] @ rotation((np.pi, 0.0, 0.0))  # jaws bent back along the shaft
    assert not planner.solver.search(target, planner.trocar).is_solved
