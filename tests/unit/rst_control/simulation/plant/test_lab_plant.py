# SPDX-License-Identifier: BSD-3-Clause
"""The simulated robot with a plant that is not ideal: each effect where it belongs."""

from dataclasses import replace

import numpy as np
import pytest

from bench.site.late_robot import LateRobot
from rst_control.config import load_simulation_config
from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.types import Setpoint
from tests.support.jacobians import differences

CONFIG = load_simulation_config()
MODEL = load_robot()


def lab(**changes):
    plant = replace(CONFIG.plant, **changes)
    simulator = replace(CONFIG.simulator, plant="lab")
    return PybulletRobot(replace(CONFIG, simulator=simulator, plant=plant), start=10.0)


def turned(robot, joint, way, seconds):
    """Lead a joint there and back; the largest true distance from its course on the way [rad]."""
    begin, worst = np.array(robot.target), 0.0
    count = round(seconds / 0.002)
    for number in range(count):
        share = (1.0 - np.cos(2.0 * np.pi * number / count)) / 2.0
        speed = np.pi / seconds * np.sin(2.0 * np.pi * number / count)
        position, velocity = begin.copy(), np.zeros(10)
        position[joint] += way * share
        velocity[joint] = way * speed
        robot.servo_jp(Setpoint(position, velocity, robot.now))
        robot.advance(robot.now + 0.002)
        worst = max(worst, abs(robot.true.position[joint] - robot.target[joint]))
    return worst


def test_the_ideal_robot_has_no_plant():
    with PybulletRobot(CONFIG, start=10.0) as robot:
        assert robot.plant is None
        robot.advance(10.05)
        np.testing.assert_array_equal(robot.true.position, robot.reading.position)


def test_friction_and_gears_keep_the_joint_off_its_course_by_milliradians_at_most():
    with lab() as robot:
        worst = turned(robot, 1, 0.1, 2.0)
    assert 1e-4 < worst < 5e-3


def test_what_is_read_is_not_what_is():
    with lab() as robot:
        turned(robot, 1, 0.1, 1.0)
        off = np.abs(robot.reading.position - robot.true.position)[:7]
        assert 1e-5 < off.max() < 5e-3
        steps = np.array(CONFIG.plant.encoders.step)
        counts = robot.reading.position / steps
        np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)


def test_pitch_and_yaw_stay_behind_by_half_the_play():
    with lab() as robot:
        begin = np.array(robot.target)
        for number in range(500):
            position = begin.copy()
            position[7] += 0.2 * min(1.0, number / 400)
            robot.servo_jp(Setpoint(position, np.zeros(10), robot.now))
            robot.advance(robot.now + 0.002)
        behind = robot.target[7] - robot.true.position[7]
    assert behind == pytest.approx(0.5 * CONFIG.plant.tool_play.width, abs=1e-3)


def test_a_shaft_that_stands_feels_the_breath():
    with lab() as robot:
        forces = []
        robot.advance(12.0, lambda: forces.append(np.linalg.norm(robot.plant.wall_force)))
    wall = CONFIG.plant.body_wall
    assert max(forces) == pytest.approx(wall.stiffness * (wall.stroke - wall.slack), rel=0.05)


def test_the_torques_that_are_read_bear_the_body_wall():
    quiet = replace(CONFIG.plant.torque_sensors, noise=(0.0,) * 7, drift=(0.0,) * 7)
    with lab(torque_sensors=quiet) as robot:
        robot.advance(10.1)
        assert not robot.plant.wall_force.any()
        np.testing.assert_allclose(robot.reading.effort, robot.true.effort, atol=1e-12)
        robot.advance(12.0)
        force, trocar = robot.plant.wall_force, robot.plant.trocar
        q = planning_joints(robot.true.position)[0]
        wall = (robot.reading.effort - robot.true.effort)[:7]

    def pressed(q):
        """The same point of the shaft, wherever it goes."""
        return (Configuration(MODEL, q).T_base_shaft @ at)[:3]

    at = np.linalg.solve(Configuration(MODEL, q).T_base_shaft, [*trocar, 1.0])
    at[:2] = 0.0
    assert np.linalg.norm(force) > 1.5
    assert np.abs(wall).max() > 0.5
    np.testing.assert_allclose(wall, -(force @ differences(pressed, q))[:7], atol=2e-3)


def test_the_same_seed_gives_the_same_run():
    def run(seed):
        with lab(seed=seed) as robot:
            robot.advance(10.3)
            return robot.reading.position, robot.force

    first, again, other = run(1), run(1), run(2)
    np.testing.assert_array_equal(first[0], again[0])
    np.testing.assert_array_equal(first[1], again[1])
    assert np.any(first[1] != other[1])


def test_set_points_and_feedback_come_late():
    with lab() as robot:
        late, lateness = LateRobot(robot, CONFIG.plant.lateness, 0.002, 1), CONFIG.plant.lateness
        ages = []
        for _ in range(200):
            late.deliver()
            robot.step()
            measured = late.measured_js()
            if measured is not None:
                ages.append(robot.now - measured.sent)
        assert min(ages) >= lateness.feedback_delay
        assert (
            max(ages)
            <= lateness.feedback_delay + lateness.feedback_jitter + 0.002 + 2 * robot.time_step
        )
        position = np.array(robot.target)
        late.servo_jp(Setpoint(position, np.zeros(10), robot.now))
        late.deliver()
        assert robot.newest_setpoint == -np.inf  # it is on its way
        robot.advance(robot.now + 0.01, late.deliver)
        assert robot.newest_setpoint > 0.0
