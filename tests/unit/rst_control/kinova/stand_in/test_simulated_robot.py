# SPDX-License-Identifier: BSD-3-Clause
"""Both stand-in drivers on the simulated robot: what PyBullet does is what they say."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import load_simulation_config
from rst_control.kinova.stand_in import KinovaRobot, as_driven, load_stand_in_config
from rst_control.simulation.pybullet_robot import PybulletRobot
from tests.unit.rst_control.support.kinova_rig import FakeGoal

PERIOD = 2  # steps of the physics to one of the drivers, as in the node


@pytest.fixture
def rig():
    config, stand_in = load_simulation_config(), load_stand_in_config()
    hasty = replace(stand_in.tool, homing_speed=1.4, homing_dwell=0.02)
    stand_in = replace(stand_in, tool=hasty)
    with PybulletRobot(config) as robot:
        yield Rig(robot, KinovaRobot(stand_in, config.limits, robot))


class Rig:
    def __init__(self, robot, drivers):
        self.robot, self.drivers = robot, drivers
        self.start = np.array(robot.reading.position)

    def run(self, seconds, until=lambda: False):
        end = self.robot.now + seconds
        while self.robot.now < end and not until():
            self.drivers.step()
            for _ in range(PERIOD):
                self.robot.step()

    @property
    def moved(self):
        """Of each joint from the start [rad]. Shape (10,)."""
        return self.robot.reading.position - self.start


def test_left_alone_it_holds(rig):
    rig.run(1.0)
    assert np.abs(rig.moved).max() < 1e-5
    assert rig.robot.fault == ""
    assert not rig.drivers.is_moving


def test_a_goal_moves_the_arm_and_leaves_the_tool(rig):
    begin, end = rig.start[:7], rig.start[:7] + 0.05 * np.eye(7)[6]
    goal = FakeGoal((begin, 0.0), (end, 1.0))
    rig.drivers.driver.take_goal(goal)
    rig.run(4.0)
    assert goal.said == ["accepted", ("succeeded", 0)]
    assert rig.robot.fault == ""
    assert rig.moved == pytest.approx(np.eye(10)[6] * 0.05, abs=1e-5)


def test_speeds_and_stop(rig):
    rig.drivers.driver.take_speeds({6: 0.1})
    rig.run(0.5)
    rig.drivers.driver.take_stop()
    rig.run(0.5)
    there = rig.moved[6]
    assert 0.03 < there < 0.07
    rig.run(0.5)
    assert rig.moved[6] == pytest.approx(there, abs=1e-6)
    assert rig.robot.fault == ""


def test_feedback_wraps_to_one_turn_and_shows_what_gravity_asks_of_the_motors(rig):
    rig.run(0.2)
    readings = [rig.drivers.arm_feedback() for _ in range(400)]
    assert readings[0].position == pytest.approx(rig.start[:7], abs=1e-4)
    offset = load_stand_in_config().driver.torque.offset
    mean = np.mean([r.effort for r in readings], axis=0)
    assert mean == pytest.approx(rig.robot.reading.effort[:7] + offset, abs=0.03)
    assert np.abs(rig.robot.reading.effort[:7]).max() > 5.0  # N m: the arm is heavy
    rig.drivers.driver.take_speeds({6: -0.8})
    rig.run(3.0)
    assert rig.robot.reading.position[6] < -np.pi
    turned = rig.drivers.arm_feedback().position[6]
    assert turned == pytest.approx(rig.robot.reading.position[6] + 2.0 * np.pi)


def test_a_pull_at_the_tool_shows_in_the_reported_torques(rig):
    rig.run(0.1)
    quiet = np.mean([rig.drivers.arm_feedback().effort for _ in range(400)], axis=0)
    rig.robot.push_load(np.array([0.0, 0.0, -5.0]))
    rig.run(0.1)
    pulled = np.mean([rig.drivers.arm_feedback().effort for _ in range(400)], axis=0)
    assert np.abs(pulled - quiet).max() > 1.0


def test_the_tool_is_silent_until_it_is_ready_and_moves_as_it_homes(rig):
    tool = rig.drivers.tool
    assert rig.drivers.tool_feedback() is None
    tool.request("connect", lambda _: None)
    answers = []
    tool.request("calibrate", answers.append)
    rig.run(20.0, until=lambda: rig.robot.reading.position[7] > 1.49)
    assert rig.robot.reading.position[7] > 1.49
    rig.run(60.0, until=lambda: answers)
    rig.run(0.1)
    assert rig.drivers.tool_feedback() == pytest.approx([0.0, 0.0, 0.0], abs=1e-4)
    assert np.abs(rig.moved[:7]).max() < 1e-4


def test_the_tool_at_its_full_speed_is_no_fault_of_the_simulated_joints(rig):
    tool, answers = rig.drivers.tool, []
    tool.request("connect", lambda _: None)
    tool.request("calibrate", answers.append)
    rig.run(60.0, until=lambda: answers)
    tool.request("pos_control_on", lambda _: None)
    for command in ([1.4, 1.5, 1.5], [-1.4, 0.0, 0.0], [9.0, 9.0, 9.0]):
        tool.take_command(command)
        rig.run(4.0)
    assert rig.robot.fault == ""
    stops = load_stand_in_config().tool.stops
    assert rig.robot.reading.position[7:] == pytest.approx(stops, abs=1e-4)


def test_a_blocked_joint_is_a_fault_of_the_arm_until_it_is_cleared(rig):
    goal = FakeGoal((rig.start[:7], 0.0), (rig.start[:7] + 0.05, 2.0))
    rig.drivers.driver.take_goal(goal)
    rig.run(2.5)
    rig.robot.fail("joint_4 is blocked")
    rig.run(1.0)
    assert goal.said == ["accepted", ("aborted", -4)]
    assert "blocked" in rig.drivers.driver.arm.fault
    here = np.array(rig.robot.reading.position)
    rig.drivers.driver.take_speeds({6: 0.1})
    rig.run(0.5)
    assert rig.robot.reading.position == pytest.approx(here, abs=1e-5)
    rig.drivers.driver.take_clear_faults()
    rig.run(0.2)
    rig.drivers.driver.take_speeds({6: 0.1})
    rig.run(0.5)
    assert rig.robot.reading.position[6] > here[6] + 0.02
    assert rig.robot.fault == ""


def test_tissue_openings_of_the_stand_in_replace_those_of_the_simulator():
    stand_in = load_stand_in_config()
    changed = as_driven(load_simulation_config().simulator, stand_in.tool)
    assert changed.closed_opening == stand_in.tool.closed_opening
    assert changed.held_opening == stand_in.tool.held_opening
