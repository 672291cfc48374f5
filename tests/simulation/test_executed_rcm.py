# SPDX-License-Identifier: BSD-3-Clause
"""Planned paths on the simulated robot: how far shaft and tip leave their course, by PyBullet."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from rst_control.config import load_motion_config, load_simulation_config
from rst_control.kinematics.configuration import Configuration, planning_joints, robot_joints
from rst_control.kinematics.rcm import rcm_error_vector
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.planner import Planner
from rst_control.robot.setpoint_servo import ServoState
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.trajectory.motion_profile import MotionBounds, MotionProfile
from rst_control.trajectory.path import Path
from rst_control.types import PathState, Setpoint

MOTION = load_motion_config()
SIMULATION = load_simulation_config()
MODEL = load_robot()
PERIOD = 1.0 / MOTION.controller.rate


@dataclass
class Course:
    """A path driven at 500 Hz on the simulated robot, looked at after every step of the physics."""

    robot: PybulletRobot
    opening: float = 0.0
    rcm: list[float] = field(default_factory=list)
    tip: list[float] = field(default_factory=list)

    def drive(self, path: Path, speed: float, until: float = np.inf) -> None:
        """Send the path at up to `speed` [m/s]; stop sending after `until` [s]."""
        bounds = MotionBounds(
            speed, MOTION.controller.speed.acceleration, MOTION.controller.speed.jerk
        )
        profile = MotionProfile(PathState(0.0), bounds)
        profile.go_to(path.length)
        end = self.robot.now + until
        while not profile.is_done and self.robot.now < end:
            state = profile.step(PERIOD)
            point = path.evaluate(state.s)
            self._send(
                robot_joints(point.q, self.opening), robot_joints(point.dq * state.speed, 0.0)
            )
        if profile.is_done:
            self.wait(0.05)

    def turn_jaws(self, q: np.ndarray, opening: float, duration: float = 0.6) -> None:
        """Open or close the jaws while the tip stands still."""
        rate = (opening - self.opening) / duration
        self._send(robot_joints(q, self.opening), np.zeros(10))  # a motion begins where it holds
        for _ in range(round(duration / PERIOD)):
            self.opening += rate * PERIOD
            velocity = robot_joints(np.zeros(9), rate)
            self._send(robot_joints(q, self.opening), velocity)
        self.opening = opening
        self._send(robot_joints(q, opening), np.zeros(10))
        self.wait(0.05)

    def wait(self, duration: float) -> None:
        """Send nothing for a while."""
        self.robot.advance(self.robot.now + duration, self._look)

    def _send(self, position: np.ndarray, velocity: np.ndarray) -> None:
        self.robot.servo_jp(Setpoint(position, velocity, self.robot.now))
        self.wait(PERIOD)

    def _look(self) -> None:
        first, second = self.robot.shaft()
        direction = (second - first) / np.linalg.norm(second - first)
        trocar = np.array(SIMULATION.scene.trocar)
        self.rcm.append(float(np.linalg.norm(rcm_error_vector(first, direction, trocar))))
        asked = Configuration(MODEL, planning_joints(self.robot.target)[0]).tip
        self.tip.append(float(np.linalg.norm(self.robot.tip - asked)))


@pytest.fixture(scope="module")
def planner():
    return Planner(MODEL, MOTION)


def robot(**changes) -> PybulletRobot:
    return PybulletRobot(replace(SIMULATION, simulator=replace(SIMULATION.simulator, **changes)))


@pytest.mark.parametrize("load", [0.0, 2.0])
@pytest.mark.parametrize("speed", [0.02, 0.05])
def test_shaft_and_tip_keep_their_course_in_motion(planner, speed, load):
    with robot(tool_load=load) as arm:
        course = Course(arm)
        for path in planner.reach(np.array(SIMULATION.scene.home)):
            course.drive(path, speed)
        assert arm.fault == ""
    rms = float(np.sqrt(np.mean(np.square(course.rcm))))
    print(
        f"\n{speed * 1e3:.0f} mm/s, {load} N: rcm max {max(course.rcm) * 1e6:.3f} um, "
        f"rms {rms * 1e6:.3f} um; tip max {max(course.tip) * 1e6:.3f} um"
    )
    assert max(course.rcm) < 10e-6
    assert rms < 3e-6
    assert max(course.tip) < 25e-6


def test_tissue_is_grasped_pulled_and_released_without_leaving_the_trocar(planner):
    with robot() as arm:
        course = Course(arm)
        course.turn_jaws(np.array(SIMULATION.scene.home), 0.6)
        ways = planner.reach(np.array(SIMULATION.scene.home))
        for path in ways:
            course.drive(path, 0.02)
        q = ways[-1].end
        course.turn_jaws(q, 0.0)
        assert arm.measured_js().gripped
        assert arm.measured_js().tension < 0.05
        pull = planner.pull(q)
        course.drive(pull, 0.01, until=1.2)
        course.wait(1.0)
        tension = arm.measured_js().tension
        assert 0.5 < tension < 2.0
        assert arm.servo_state is ServoState.HOLDING
        arm.clear_fault()
        course.turn_jaws(planning_joints(arm.target)[0], 0.6)
        assert not arm.measured_js().gripped
        assert arm.measured_js().tension == 0.0
    print(f"\npull and release: {tension:.2f} N, rcm max {max(course.rcm) * 1e6:.2f} um")
    assert max(course.rcm) < 10e-6


@pytest.mark.parametrize("speed", [0.02, 0.05])
def test_when_setpoints_stop_the_arm_comes_to_rest_near_the_trocar(planner, speed):
    with robot() as arm:
        course = Course(arm)
        path = planner.reach(np.array(SIMULATION.scene.home))[0]
        course.drive(path, speed, until=0.35)
        sent, tip = arm.now, arm.tip
        course.wait(0.5)
        assert "stopped coming" in arm.fault
        assert arm.servo_state is ServoState.HOLDING
        held = arm.reading.position
        course.wait(0.5)
        assert np.abs(arm.reading.position - held).max() < 1e-6
        way = float(np.linalg.norm(arm.tip - tip))
    print(
        f"\n{speed * 1e3:.0f} mm/s: {way * 1e3:.2f} mm from the last set-point on ({sent:.2f} s), "
        f"rcm max {max(course.rcm) * 1e6:.1f} um"
    )
    assert max(course.rcm) < 10e-6
    assert way < 0.1 * speed


def test_a_tool_whose_joints_are_truly_elsewhere_moves_the_tip_but_not_the_shaft(planner):
    with robot(tool_joint_error=(0.11, 0.0, 0.0)) as arm:
        course = Course(arm)
        for path in planner.reach(np.array(SIMULATION.scene.home)):
            course.drive(path, 0.02)
        assert np.abs(arm.reading.position - arm.target).max() < 1e-5
    assert max(course.rcm) < 10e-6
    assert 1e-3 < max(course.tip) < 5e-3
