# SPDX-License-Identifier: BSD-3-Clause
"""The robot without physics: it does what tests of the controller rely on."""

from __future__ import annotations

import numpy as np
import pytest

from rst_control.kinematics.configuration import robot_joints
from rst_control.robot.backend import RobotBackend
from rst_control.types import Setpoint
from tests.support.fake_robot import FakeRobot, LinearSpring


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


def point(value: float, stamp: float = 0.0) -> Setpoint:
    return Setpoint(np.full(10, value), np.zeros(10), stamp)


def test_a_setpoint_is_reached_at_once(clock):
    robot: RobotBackend = FakeRobot(np.zeros(10), clock)
    robot.servo_jp(point(0.3))
    assert np.array_equal(robot.measured_js().position, np.full(10, 0.3))


def test_with_a_lag_it_is_approached(clock):
    robot = FakeRobot(np.zeros(10), clock, lag=0.1)
    robot.servo_jp(point(1.0))
    clock.now = 0.1
    assert robot.measured_js().position[0] == pytest.approx(1.0 - np.exp(-1.0))


def test_hold_stops_it_where_it_is(clock):
    robot = FakeRobot(np.zeros(10), clock, lag=0.1)
    robot.servo_jp(point(1.0))
    clock.now = 0.1
    robot.hold()
    where = robot.measured_js().position[0]
    clock.now = 1.0
    assert robot.measured_js().position[0] == where
    assert robot.hold_count == 1


def test_a_fault_stops_it_until_it_is_cleared(clock):
    robot = FakeRobot(np.zeros(10), clock)
    robot.fault = "made up"
    robot.servo_jp(point(0.3))
    assert not robot.measured_js().position.any()
    assert robot.measured_js().fault == "made up"
    robot.clear_fault()
    robot.servo_jp(point(0.3))
    assert robot.measured_js().position.all()


def test_frozen_joint_states_grow_old(clock):
    robot = FakeRobot(np.zeros(10), clock)
    robot.freeze()
    clock.now = 1.0
    robot.servo_jp(point(0.3))
    assert robot.measured_js().stamp == 0.0
    robot.thaw()
    assert robot.measured_js().stamp == 1.0


def test_jaws_that_open_and_close_take_the_spring_and_feel_its_force(clock):
    spring = LinearSpring(lambda joints: joints[:3], stiffness=100.0)
    robot = FakeRobot(np.zeros(10), clock, tissue=spring)
    assert not robot.measured_js().gripped
    for opening in (0.5, 0.0):
        robot.servo_jp(Setpoint(robot_joints(np.zeros(9), opening), np.zeros(10), 0.0))
        robot.measured_js()
    assert robot.measured_js().gripped
    q = np.zeros(9)
    q[0] = 0.01
    robot.servo_jp(Setpoint(robot_joints(q, 0.0), np.zeros(10), 0.0))
    assert robot.measured_js().force == pytest.approx([-1.0, 0.0, 0.0])
    robot.servo_jp(Setpoint(robot_joints(q, 0.5), np.zeros(10), 0.0))
    assert robot.measured_js().tension == 0.0
