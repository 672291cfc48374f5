# SPDX-License-Identifier: BSD-3-Clause
"""A set-point that nobody of ours sent, while the robot holds: refused, or too near to do harm."""

from itertools import product

import numpy as np
import pytest

from rst_control.assembly import make_trocar_context
from rst_control.config import load_motion_config, load_simulation_config
from rst_control.kinematics.robot_model import load_robot
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.robot.setpoint_servo import Servo
from rst_control.simulation.pybullet_robot import servo_limits, start_joints
from rst_control.types import JOINT_COUNT, Setpoint

MOTION, SIMULATION = load_motion_config(), load_simulation_config()
SERVO = SIMULATION.simulator.servo
LED = 8  # joints that place shaft and tip: seven of the arm, and pitch


@pytest.fixture(scope="module")
def context():
    return ActiveTrocarContext(make_trocar_context(MOTION, load_robot()))


def after(away):
    """Where the robot is half a second after a stray set-point that far from where it held."""
    home = start_joints(SIMULATION)
    robot = Servo(SERVO, servo_limits(MOTION.limits), home)
    robot.course(0.999)
    robot.accept(Setpoint(home + away, np.zeros(JOINT_COUNT), 1.0), 1.0)
    for k in range(500):
        position, _ = robot.course(1.0 + 1e-3 * k)
    return robot, position


@pytest.mark.parametrize("joint", range(JOINT_COUNT))
def test_one_that_is_further_away_is_a_fault_and_moves_nothing(joint):
    away = np.zeros(JOINT_COUNT)
    away[joint] = 1.02 * SERVO.start_tolerance
    robot, position = after(away)
    assert "away from where it holds" in robot.fault
    np.testing.assert_array_equal(position, start_joints(SIMULATION))


def test_one_that_is_taken_leaves_the_shaft_on_its_trocar_whatever_its_signs(context):
    errors = []
    for signs in product((-1.0, 1.0), repeat=LED):
        away = np.zeros(JOINT_COUNT)
        away[:LED] = 0.98 * SERVO.start_tolerance * np.array(signs)
        errors.append(context.trocar_pose(start_joints(SIMULATION) + away).rcm_error)
    assert max(errors) < MOTION.rcm.measured_tolerance
    worst = max(range(len(errors)), key=errors.__getitem__)
    signs = np.array(list(product((-1.0, 1.0), repeat=LED))[worst])
    away = np.concatenate([0.98 * SERVO.start_tolerance * signs, np.zeros(JOINT_COUNT - LED)])
    robot, position = after(away)
    assert robot.fault == "" and np.abs(position - start_joints(SIMULATION) - away).max() < 1e-9
