# SPDX-License-Identifier: BSD-3-Clause
"""Properties of the distance between shaft and trocar, and of its Jacobian."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rst_control.kinematics import constrained_ik, forward
from rst_control.kinematics.configuration import Configuration, planning_joints, robot_joints
from rst_control.kinematics.rcm import rcm_error_vector, rcm_state
from rst_control.kinematics.robot_model import load_robot, rotation
from tests.support.jacobians import differences

TROCAR = np.array([0.406, -0.024, 0.415])

coordinates = st.floats(-1.0, 1.0)
points = st.tuples(coordinates, coordinates, coordinates).map(np.array)
angles = st.floats(-2.0, 2.0)
configurations = st.lists(angles, min_size=9, max_size=9).map(np.array)


@st.composite
def directions(draw):
    vector = draw(points.filter(lambda v: np.linalg.norm(v) > 0.05))
    return vector / np.linalg.norm(vector)


@given(directions(), points, points)
def test_error_is_square_to_the_shaft_and_ends_on_it(d, p, trocar):
    """That is one vector alone: the shortest, whichever point of the shaft is given."""
    error = rcm_error_vector(p, d, trocar)
    assert abs(error @ d) < 1e-12
    assert np.linalg.norm(np.cross(trocar - error - p, d)) < 1e-12


@given(configurations, points)
def test_lateral_errors_are_the_error_in_the_frame_of_the_shaft(q, trocar):
    configuration = Configuration(load_robot(), q)
    T, state = configuration.T_base_shaft, rcm_state(configuration, trocar)
    error = T[:3, :3].T @ rcm_error_vector(T[:3, 3], T[:3, 2], trocar)
    assert_allclose([*state.lateral, 0.0], error, atol=1e-12)
    assert abs(state.error - np.linalg.norm(error)) < 1e-12


@given(configurations, st.booleans())
def test_small_joint_steps_change_the_residual_by_minus_the_constraints(q, is_straight):
    model = load_robot()
    frames, r, J = np.empty((12, 3, 4)), np.empty(8), np.zeros((8, 9))
    forward.forward(model.chain, q, frames)
    target = frames[forward.TIP].copy()
    constrained_ik.constraints(frames, TROCAR, J)
    if is_straight:
        constrained_ik.hold_wrist(q, r, J)

    def missing(joints):
        forward.forward(model.chain, joints, frames)
        constrained_ik.residual(frames, target, TROCAR, r)
        if is_straight:
            constrained_ik.hold_wrist(joints, r, np.empty((8, 9)))
        return r.copy()

    assert_allclose(-J, differences(missing, q), atol=1e-7)


@given(points, points)
def test_turn_between_two_frames_turns_one_into_the_other(a, b):
    first, second, turn = rotation(3.0 * a), rotation(3.0 * b), np.empty(3)
    forward.turn_between(first, second, turn)
    angle = np.linalg.norm(turn)
    assert angle <= np.pi + 1e-9
    axis = turn / angle if angle > 1e-12 else np.array([0.0, 0.0, 1.0])
    K = np.cross(np.eye(3), axis)
    R = np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K
    assert_allclose(R @ first, second, atol=1e-7)


def test_turn_between_opposite_frames_is_half_a_turn():
    for axis in np.eye(3):
        turn = np.empty(3)
        forward.turn_between(np.eye(3), 2.0 * np.outer(axis, axis) - np.eye(3), turn)
        assert_allclose(np.abs(turn), np.pi * axis, atol=1e-9)


@given(configurations, st.floats(0.0, 1.0))
def test_jaws_give_back_the_yaw_and_opening_they_were_made_of(q, opening):
    again, open_again = planning_joints(robot_joints(q, opening))
    assert_allclose(again, q, atol=1e-12)
    assert abs(open_again - opening) < 1e-12
