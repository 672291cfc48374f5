# SPDX-License-Identifier: BSD-3-Clause
"""What the set-point becomes when the measured joints are taken over."""

import numpy as np
import pytest

from rst_control.execution.motion import MotionMaker
from rst_control.execution.setpoint import SetpointState
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.types import Measurement


@pytest.fixture
def setpoint(motion_config):
    return SetpointState(MotionMaker(motion_config.controller))


def measured(joints, now=1.0, gripped=True):
    still = np.zeros(10)
    return Measurement(joints, still, still, now, gripped=gripped)


@pytest.mark.parametrize(("gripped", "opening"), [(False, 0.1), (True, 0.0)])
def test_only_jaws_that_hold_tissue_are_sent_to_close_where_it_keeps_them_open(
    setpoint, home, gripped, opening
):
    kept_open = robot_joints(home, 0.1)
    setpoint.synchronise(measured(kept_open, gripped=gripped))
    q, sent = planning_joints(setpoint.held)
    np.testing.assert_allclose(q, home, atol=1e-12)
    assert sent == pytest.approx(opening)


def test_wide_open_jaws_are_not_sent_to_close_whatever_a_sensor_says(setpoint, home):
    wide = robot_joints(home, 0.4)
    setpoint.synchronise(measured(wide))
    np.testing.assert_array_equal(setpoint.held, wide)


@pytest.mark.parametrize("last", [0.09, 0.3])
def test_a_false_word_of_tissue_after_a_loss_does_not_move_jaws_that_stand_half_open(
    setpoint, home, last
):
    setpoint.synchronise(measured(robot_joints(home, last), gripped=False))
    setpoint.lose()
    half_open = robot_joints(home, 0.09)
    setpoint.synchronise(measured(half_open, now=2.0))
    np.testing.assert_allclose(setpoint.held, half_open, atol=1e-12)


def test_jaws_that_hold_tissue_stay_sent_where_they_were_after_a_loss(setpoint, home):
    kept_open = measured(robot_joints(home, 0.1))
    setpoint.synchronise(kept_open)
    for _ in range(3):
        setpoint.lose()
        setpoint.synchronise(kept_open)
        assert planning_joints(setpoint.held)[1] == pytest.approx(0.0)


def test_jaws_that_stopped_half_open_stay_where_the_robot_holds_them(setpoint, home):
    """Of a release that was cut off; a controller that is started anew cannot know of it."""
    half_open = robot_joints(home, 0.041)
    setpoint.synchronise(measured(half_open), half_open)
    np.testing.assert_array_equal(setpoint.held, half_open)
    setpoint.lose()
    setpoint.synchronise(measured(half_open, now=2.0))
    assert planning_joints(setpoint.held)[1] == pytest.approx(0.041)  # as it remembers
