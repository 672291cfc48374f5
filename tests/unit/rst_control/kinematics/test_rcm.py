# SPDX-License-Identifier: BSD-3-Clause
from __future__ import annotations

import numpy as np
import pytest

from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rcm import rcm_error_vector, rcm_state


def test_a_trocar_beside_a_vertical_shaft_is_its_horizontal_distance_away():
    error = rcm_error_vector(np.zeros(3), np.array([0.0, 0.0, -1.0]), np.array([0.003, 0.004, 0.2]))
    np.testing.assert_allclose(error, [0.003, 0.004, 0.0], atol=1e-15)


def test_a_trocar_on_the_shaft_gives_no_error_and_its_depth(robot, home):
    T = Configuration(robot, home).T_base_shaft
    state = rcm_state(Configuration(robot, home), T[:3, 3] + 0.18 * T[:3, 2])
    assert state.error < 1e-15
    assert state.insertion == pytest.approx(robot.shaft_length - 0.18)


def test_moving_the_trocar_sideways_shows_as_that_error(robot, home):
    T = Configuration(robot, home).T_base_shaft
    point = T[:3, 3] + 0.2 * T[:3, 2] + 0.001 * T[:3, 0] - 0.002 * T[:3, 1]
    assert rcm_state(Configuration(robot, home), point).lateral == pytest.approx((0.001, -0.002))


def test_pitch_and_yaw_do_not_move_the_shaft(robot, home, motion_config):
    trocar = np.array(motion_config.scene.trocar)
    bent = home.copy()
    bent[7:] += 0.4
    assert rcm_state(Configuration(robot, bent), trocar).error < 1e-9
