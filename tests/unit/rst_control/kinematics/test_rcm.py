# SPDX-License-Identifier: BSD-3-Clause
import pytest

from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rcm import rcm_state


def test_a_trocar_on_the_shaft_gives_no_error_and_its_depth(robot, home):
    T = Configuration(robot, home).T_base_shaft
    state = rcm_state(Configuration(robot, home), T[:3, 3] + 0.18 * T[:3, 2])
    assert state.error < 1e-15
    assert state.insertion == pytest.approx(robot.shaft_length - 0.18)
