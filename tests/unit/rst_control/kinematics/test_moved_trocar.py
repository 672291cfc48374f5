# SPDX-License-Identifier: BSD-3-Clause
"""Joints that keep the shaft in a trocar which has moved."""

import numpy as np
import pytest

from rst_control.config import load_motion_config
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.moved_trocar import shifted_joints, tip_share
from rst_control.kinematics.rcm import rcm_state
from rst_control.kinematics.robot_model import load_robot

MODEL, SCENE = load_robot(), load_motion_config().scene
HOME, TROCAR = np.array(SCENE.home), np.array(SCENE.trocar)
SHIFTS = [(0.005, 0.0, 0.0), (0.0, 0.008, 0.0), (-0.003, 0.004, 0.002), (0.0, 0.0, 0.005)]


def at(q):
    return Configuration(MODEL, q)


@pytest.mark.parametrize("shift", SHIFTS)
def test_the_shaft_is_in_the_moved_trocar_and_the_tip_where_it_was(shift):
    change = shifted_joints(MODEL, HOME, TROCAR, np.array(shift))
    assert rcm_state(at(HOME + change), TROCAR + shift).error < 1e-9
    np.testing.assert_allclose(at(HOME + change).tip, at(HOME).tip, atol=1e-9)
    assert np.all(change[7:] == 0.0)


def test_a_shaft_beside_the_trocar_stays_as_far_beside_it():
    q = HOME + np.array([0.001, -0.002, 0.0, 0.001, 0.0, 0.0, 0.0, 0.0, 0.0])
    before = rcm_state(at(q), TROCAR)
    shift = np.array([0.004, -0.002, 0.0])
    after = rcm_state(at(q + shifted_joints(MODEL, q, TROCAR, shift)), TROCAR + shift)
    np.testing.assert_allclose(after.lateral, before.lateral, atol=1e-9)


def test_no_shift_changes_nothing():
    assert not shifted_joints(MODEL, HOME, TROCAR, np.zeros(3)).any()


@pytest.mark.parametrize("beyond", [0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4, 9.9e-4, 1.01e-3])
def test_where_the_tip_is_in_the_trocar_the_tool_goes_along_as_a_whole(beyond):
    tool = at(HOME)
    tip = tool.tip
    shift = np.array([0.004, 0.0, 0.0])
    trocar = tip - beyond * tool.T_base_shaft[:3, 2]
    change = shifted_joints(MODEL, HOME, trocar, shift)
    np.testing.assert_allclose(at(HOME + change).tip, tip + shift, atol=1e-9)
    assert np.abs(change).max() < 0.01


def test_the_share_of_the_tip_rises_smoothly_with_depth():
    depths = np.linspace(-0.1, 0.2, 301)
    shares = np.array([tip_share(depth) for depth in depths])
    assert shares[0] == 0.0 and shares[-1] == 1.0
    assert np.all(np.diff(shares) >= 0.0) and np.diff(shares).max() < 0.04
