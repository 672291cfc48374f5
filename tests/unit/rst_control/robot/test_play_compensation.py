# SPDX-License-Identifier: BSD-3-Clause
"""A tool with play, whose motors are sent ahead of its joints."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import load_motion_config, load_simulation_config
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.robot.play_compensation import REVERSAL, PlayCompensation
from rst_control.simulation.plant.tool_play import ToolPlay
from rst_control.types import Measurement, Setpoint, State
from tests.support.changed_settings import changed

CONFIG = load_motion_config()
PLAY = load_simulation_config().plant.tool_play
PERIOD, HALF = 0.002, 0.5 * PLAY.width
CLOSE = 2.0 * REVERSAL  # [rad] of a joint from its set-point


def settings(width):
    return changed(CONFIG, tool_play={"width": (width, width)})


class WornTool:
    """A robot whose pitch and yaw have play; it measures its motors."""

    def __init__(self, start=(0.0, 0.0), width=PLAY.width):
        self.now, self.motors, self.load, self.gripped = 10.0, np.zeros(10), np.zeros(2), False
        self.play = ToolPlay(replace(PLAY, width=width), np.array(start), PERIOD)
        self.speed, self.held, self.fault, self.connected = np.zeros(10), 0, "", True

    def measured_js(self):
        return Measurement(
            *(self.motors, self.speed, np.zeros(10), self.now),
            gripped=self.gripped,
            fault=self.fault,
            connected=self.connected,
        )

    def servo_jp(self, setpoint):
        self.motors, self.speed = setpoint.position, setpoint.velocity
        self.play.advance(planning_joints(self.motors)[0][7:], self.load)

    def hold(self):
        self.held += 1

    def clear_fault(self):
        self.held = 0


class Led:
    """The tool behind its compensation, led along courses of pitch and yaw."""

    def __init__(self, width=PLAY.width, opening=0.0, **tool):
        self.tool, self.state, self.opening = WornTool(**tool), State.MOVING, opening
        self.robot = PlayCompensation(self.tool, settings(width), lambda: self.state)
        self.q, self.errors = np.zeros(2), []

    def step(self, q):
        self.tool.now += PERIOD
        speed, self.q = (np.array(q) - self.q) / PERIOD, np.array(q)
        self.robot.measured_js()
        self.robot.servo_jp(
            Setpoint(
                robot_joints(np.array([0.0] * 7 + [*q]), self.opening),
                robot_joints(np.array([0.0] * 7 + [*speed]), 0.0),
                self.tool.now,
            )
        )
        self.errors.append(np.abs(self.tool.play.position - self.q).max())

    def go(self, way, seconds=4.0):
        begin = self.q
        for share in np.linspace(0.0, 1.0, round(seconds / PERIOD) + 1)[1:]:
            self.step(begin + (1.0 - np.cos(np.pi * share)) / 2.0 * np.array(way))
        return self

    def wait(self, seconds):
        for _ in range(round(seconds / PERIOD)):
            self.step(self.q)
        return self

    @property
    def ahead(self):
        return planning_joints(self.tool.motors)[0][7:] - self.q


@pytest.mark.parametrize("start", [(0.0, 0.0), (HALF, -HALF), (-HALF, HALF), (0.02, 0.05)])
@pytest.mark.parametrize("way", [(0.3, -0.2), (-0.02, 0.01), (-0.3, -0.3)])
def test_wherever_it_began_in_its_play_the_joint_arrives(start, way):
    led = Led(start=start).go(way)
    assert led.errors[-1] < CLOSE


def test_without_it_the_joint_stays_behind_by_half_the_play():
    assert Led(width=0.0).go((0.3, -0.2)).errors[-1] == pytest.approx(HALF)


def test_it_arrives_after_each_turn_too():
    led = Led().go((0.2, 0.2))
    for way in ((-0.1, 0.1), (0.05, -0.2), (-0.003, 0.003), (0.3, 0.1)):
        assert led.go(way).errors[-1] < CLOSE


def test_the_controller_sees_its_own_set_points():
    led, seen = Led(), []
    for way in ((0.2, 0.2), (-0.1, 0.1)):
        led.go(way)
        led.wait(0.1)
        seen.append(planning_joints(led.robot.measured_js().position)[0][7:] - led.q)
    assert np.abs(seen).max() < 1e-9
    assert np.abs(led.ahead).max() > 0.5 * HALF


def test_what_is_added_has_the_speed_that_it_says():
    led, places, speeds = Led(), [], []
    way = np.linspace(0.0, 1.0, 600)
    for share in way:
        led.step(0.2 * share * np.ones(2))
        places.append(led.tool.motors)
        speeds.append(led.tool.speed)
    np.testing.assert_allclose(np.diff(places, axis=0), PERIOD * np.array(speeds)[1:], atol=1e-9)
    config = CONFIG.controller.tool_play
    added = planning_joints(np.array(speeds)[-1])[0][7:]
    assert np.abs(added).max() < 0.2 / (599 * PERIOD) + config.speed + 1e-6


@pytest.mark.parametrize("state", [s for s in State if s is not State.MOVING])
def test_a_stop_lets_the_motors_come_to_rest(state):
    led, config = Led(), CONFIG.controller.tool_play
    led.go((0.05, 0.05), 0.3)
    before = led.ahead
    led.state = state
    led.wait(config.speed / config.acceleration)
    rest = led.ahead
    assert np.abs(rest - before).max() <= 0.5 * config.speed**2 / config.acceleration + 1e-3
    led.wait(1.0)
    np.testing.assert_array_equal(led.ahead, rest)


def test_at_rest_nothing_begins():
    led = Led()
    led.state = State.ACTIVE
    led.wait(1.0)
    np.testing.assert_array_equal(led.ahead, 0.0)


def test_what_is_held_is_not_moved_and_the_load_is_forgotten_afterwards():
    led = Led().go((0.2, 0.2))
    ahead = led.ahead
    led.tool.gripped, led.tool.load = True, np.array([0.02, -0.02])
    led.wait(0.01).go((-0.1, -0.1))
    np.testing.assert_allclose(led.ahead, ahead, atol=1e-9)
    led.tool.gripped, led.tool.load = False, np.zeros(2)
    assert led.go((0.02, -0.02)).errors[-1] < CLOSE


@pytest.mark.parametrize(
    ("fault", "is_connected"), [("tool not homed", True), ("", False), ("", True)]
)
def test_where_a_tool_lies_in_its_play_is_not_known_after_it_was_homed(fault, is_connected):
    """A homing leaves each joint anywhere in its play; without a fault there was none."""
    led = Led().go((0.3, 0.3))
    led.tool.fault, led.tool.connected = fault, is_connected
    led.robot.measured_js()
    led.tool.fault, led.tool.connected = "", True
    led.tool.play.position[:] = led.q + 2.0 * HALF  # at the other end
    led.go((0.02, 0.02))
    was_homed = bool(fault) or not is_connected
    assert (led.errors[-1] < CLOSE) == was_homed


def test_half_the_width_makes_up_for_half():
    """A play that was measured too small leaves the rest; one too large gives as much too much."""
    for share in (0.5, 1.5):
        led = Led(width=share * PLAY.width).go((0.3, 0.3))
        assert led.errors[-1] == pytest.approx(0.5 * HALF, abs=CLOSE)


def test_set_points_stay_within_the_limits_of_the_joints():
    led = Led(opening=0.6)
    limits = CONFIG.limits
    led.go((limits.pitch - 0.02, limits.finger - 0.3 - 0.02)).wait(0.5)
    motors = led.tool.motors
    assert motors[7] <= limits.pitch + 1e-12
    assert np.abs(motors[8:]).max() <= limits.finger + 1e-12
    assert motors[8] + motors[9] == pytest.approx(0.6)


def test_a_stream_that_begins_anew_begins_where_the_robot_holds():
    led = Led().go((0.05, 0.05), 0.3)
    sent = led.tool.motors
    led.robot.hold()
    led.tool.now += 1.0
    led.step(led.q)
    np.testing.assert_allclose(led.tool.motors, sent, atol=1e-12)
    assert led.tool.held == 1


def test_nothing_measured_is_nothing_seen():
    led = Led()
    led.tool.measured_js = lambda: None
    assert led.robot.measured_js() is None
    led.robot.clear_fault()
    assert led.tool.held == 0
