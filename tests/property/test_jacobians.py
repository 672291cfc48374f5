# SPDX-License-Identifier: BSD-3-Clause
"""Every derivative that planning uses and test_rcm_geometry.py does not, by finite differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from bench.motion.paths import random_paths
from rst_control.kinematics import constrained_ik, continuation, forward, manipulability
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rcm import rcm_offset
from rst_control.kinematics.robot_model import load_robot
from support.kdl_chain import Kdl
from tests.support.jacobians import differences

TROCAR = np.array([0.406, -0.024, 0.415])
RADIAN = 0.1  # [m] that a radian of the tool counts as

angles = st.floats(-2.0, 2.0)
configurations = st.lists(angles, min_size=9, max_size=9).map(np.array)


def constraints(model, q):
    frames, J = np.empty((12, 3, 4)), np.zeros((8, 9))
    forward.forward(model.chain, q, frames)
    constrained_ik.constraints(frames, TROCAR, J)
    return frames, J


# Manipulability: numpy's singular values of a Jacobian that KDL's poses give by finite differences.


@pytest.fixture(scope="module")
def kdl():
    model = load_robot()
    return Kdl(model, "interface_link"), Kdl(model, "tool_tip")


def by_kdl(kdl, q):
    """Jacobian (8, 9) of trocar and tool pose, from KDL's poses alone."""
    shaft, tip = kdl
    R = tip.frame(q)[:3, :3]

    def seen(joints):
        S, T = shaft.frame(joints[:7]), tip.frame(joints)
        lateral = (S[:3, :3].T @ (TROCAR - S[:3, 3]))[:2]
        skew = 0.5 * (T[:3, :3] @ R.T - R @ T[:3, :3].T)
        turn = RADIAN * np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        return np.concatenate([lateral, T[:3, 3], turn])

    return differences(seen, q)


@given(configurations)
def test_manipulability_is_the_product_of_the_singular_values(kdl, q):
    values = np.linalg.svd(by_kdl(kdl, q), compute_uv=False)
    found = manipulability.measure(load_robot().chain, q, TROCAR)
    # A step's error of 1e-9 in a small singular value counts as much as the others are large.
    assert found == pytest.approx(
        np.prod(values), rel=1e-5, abs=1e-8 * np.prod(values[:-1]) + 1e-13
    )


@given(configurations, st.booleans())
def test_the_free_direction_moves_neither_tool_nor_shaft(q, is_straight):
    if is_straight:
        q = np.concatenate([q[:7], [0.0, 0.0]])
    model, free = load_robot(), np.empty(9)
    if is_straight:
        _, J = constraints(model, q)
        is_singular = np.linalg.svd(J[2:, :7], compute_uv=False)[-1] < 1e-4  # the arm alone
    else:
        is_singular = manipulability.measure(model.chain, q, TROCAR) < 1e-9
    if is_singular:
        return  # more than one direction is free, or nearly so
    continuation.free_direction(model.chain, q, TROCAR, is_straight, free)
    assert np.linalg.norm(free) == pytest.approx(1.0)
    h = 1e-5
    ahead, behind = (Configuration(model, q + sign * h * free) for sign in (1.0, -1.0))
    assert_allclose(ahead.T_base_tip, behind.T_base_tip, atol=1e-8)
    if is_straight:
        assert_allclose(free[7:], 0.0, atol=1e-9)
    else:
        lateral = [rcm_offset(c.frames, TROCAR)[:2] for c in (ahead, behind)]
        assert_allclose(*lateral, atol=1e-8)


# Posture: its step descends the cost that it is said to descend.


def posture_cost(q, posture):
    reference, weight, lower, upper = posture
    x = (q - 0.5 * (lower + upper)) / (0.5 * (upper - lower))
    power = constrained_ik.LIMIT_POWER + 1
    return float((0.5 * weight * (q - reference) ** 2).sum() + (x**power).sum() / power)


@given(configurations, st.lists(st.floats(-0.5, 0.5), min_size=9, max_size=9).map(np.array))
def test_the_posture_step_goes_down_the_gradient_of_its_cost_within_the_free_motions(q, shift):
    model = load_robot()
    posture = np.array([q + shift, np.full(9, 0.3), np.full(9, -2.5), np.full(9, 2.4)])
    _, J = constraints(model, q)
    values = np.linalg.svd(J, compute_uv=False)
    if values[-1] < 1e-3:
        return
    L, step = np.zeros((8, 8)), np.zeros(9)
    constrained_ik.factor(J, 0.0, L)
    length = constrained_ik.posture_step(J, L, q, posture, step)
    gradient = differences(lambda x: np.array(posture_cost(x, posture)), q)
    free = np.linalg.svd(J)[2][-1]
    downhill = -free * float(free @ gradient)
    norm = float(np.linalg.norm(downhill))
    if norm < 1e-6:
        return
    assert length == pytest.approx(np.linalg.norm(step), rel=1e-6, abs=1e-9)
    assert_allclose(step / length, downhill / norm, atol=1e-4)
    bend = differences(
        lambda x: differences(lambda y: np.array(posture_cost(y, posture)), x, 1e-4), q, 1e-4
    )
    newton_length = norm / float(free @ bend @ free)
    assert length == pytest.approx(min(newton_length, constrained_ik.SWING_LIMIT), rel=1e-3)


# Paths: the slopes at their knots are those of the joints that solve the way, q'(s).


@pytest.fixture(scope="module")
def legs(planner):
    """Short legs between random tool poses, each tracked with many knots."""
    return [path for path, _ in random_paths(planner, 12, seed=8)]


def test_slopes_at_knots_equal_finite_differences_of_the_solved_joints(legs):
    """Differences of fourth order over knots, which know nothing of slopes."""
    for path in legs:
        k, h = path.knots, path.spacing
        central = (k[:-4] - 8.0 * k[1:-3] + 8.0 * k[3:-1] - k[4:]) / (12.0 * h)
        largest = np.abs(path.slopes).max()
        assert_allclose(path.slopes[2:-2], central, atol=1e-3 * largest)


def test_slopes_at_knots_lead_the_tool_along_its_way_and_the_shaft_through_the_trocar(
    planner, legs
):
    for path in legs:
        for q, dq in zip(path.knots, path.slopes, strict=True):
            h = 1e-6 / np.abs(dq).max()
            ahead, behind = (Configuration(planner.model, q + sign * h * dq) for sign in (1, -1))
            way = (
                Configuration(planner.model, path.end).tip
                - Configuration(planner.model, path.start).tip
            )
            assert_allclose((ahead.tip - behind.tip) / (2.0 * h), way / path.length, atol=1e-5)
            lateral = [rcm_offset(c.frames, planner.trocar)[:2] for c in (ahead, behind)]
            assert_allclose(np.subtract(*lateral) / (2.0 * h), 0.0, atol=1e-5)
