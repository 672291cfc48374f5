# SPDX-License-Identifier: BSD-3-Clause
"""An arm that yields to friction, sent beyond its set-points."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.assembly import compensated
from rst_control.config import load_motion_config
from rst_control.robot.joint_correction import JointCorrection
from rst_control.robot.play_compensation import PlayCompensation
from rst_control.types import Measurement, Setpoint, State
from typed_config import ConfigError

CONFIG = load_motion_config()
PERIOD, LAG = 0.002, CONFIG.controller.tension.delay
SETTINGS = replace(CONFIG.controller.joint_correction, gain=0.7)


def with_controller(**changes):
    return replace(CONFIG, controller=replace(CONFIG.controller, **changes))


class YieldingArm:
    """Joints a fixed distance from where they are sent, as much later as they are measured."""

    def __init__(self):
        self.now, self.off, self.sent, self.held = 10.0, np.zeros(10), [np.zeros(10)], 0
        self.rest = None

    def measured_js(self):
        late = self.sent[max(len(self.sent) - round(LAG / PERIOD), 0)]
        return Measurement(late - self.off, np.zeros(10), np.zeros(10), self.now, sent_to=self.rest)

    def servo_jp(self, setpoint):
        self.sent.append(setpoint.position)

    def hold(self):
        self.held += 1

    def clear_fault(self):
        self.held = 0


class Led:
    def __init__(self, settings=SETTINGS):
        self.arm, self.state = YieldingArm(), State.MOVING
        config = with_controller(joint_correction=settings)
        self.robot = JointCorrection(self.arm, config, lambda: self.state)
        self.place = np.zeros(10)

    def run(self, seconds, speed=0.0):
        for _ in range(round(seconds / PERIOD)):
            self.arm.now += PERIOD
            self.robot.measured_js()
            self.place = self.place + PERIOD * speed
            velocity = np.full(10, speed)
            self.robot.servo_jp(Setpoint(self.place, velocity, self.arm.now))
        return self

    @property
    def added(self):
        return self.arm.sent[-1] - self.place


def test_the_servo_yields_less_by_one_and_the_gain():
    led = Led()
    led.arm.off[2] = 0.001
    led.run(1.0)
    short = led.place - led.arm.measured_js().position
    assert short[2] == pytest.approx(0.001 / (1.0 + SETTINGS.gain), abs=1e-5)
    np.testing.assert_allclose(np.delete(short, 2), 0.0, atol=1e-9)


def test_an_arm_that_follows_gets_its_own_set_points():
    led = Led().run(0.1)
    led.run(1.0, speed=0.2)
    np.testing.assert_allclose(led.added, 0.0, atol=1e-9)


def test_the_tool_is_left_alone():
    led = Led()
    led.arm.off[7:] = 0.05
    np.testing.assert_array_equal(led.run(0.5).added, 0.0)


def test_it_is_bounded_in_size_and_speed():
    led, added = Led(), []
    led.arm.off[0] = 0.5
    for _ in range(100):
        led.run(PERIOD)
        added.append(led.added[0])
    assert max(added) == pytest.approx(SETTINGS.limit)
    assert np.diff(added).max() <= SETTINGS.speed * PERIOD + 1e-12


@pytest.mark.parametrize("state", [State.HALTED, State.FAULTED, State.STANDBY])
def test_a_latch_lets_it_fade(state):
    led = Led()
    led.arm.off[0] = 0.002
    led.run(0.5)
    assert led.added[0] > 0.0005
    led.state = state
    led.run(0.1)
    np.testing.assert_array_equal(led.added, 0.0)


def test_after_a_hold_it_begins_where_the_robot_holds():
    led = Led()
    led.arm.off[0] = 0.002
    led.run(0.5)
    sent = led.arm.sent[-1]
    led.robot.hold()
    assert led.arm.held == 1
    led.arm.rest = sent
    led.arm.now += 1.0
    assert led.robot.measured_js().sent_to[0] == pytest.approx(led.place[0])
    led.robot.servo_jp(Setpoint(led.place, np.zeros(10), led.arm.now))
    np.testing.assert_allclose(led.arm.sent[-1], sent, atol=1e-12)
    led.robot.clear_fault()
    assert led.arm.held == 0


def test_after_a_hold_nothing_is_added_by_where_the_arm_was_led_before():
    led = Led().run(0.5)
    led.robot.hold()
    led.place = led.place + 0.3  # it was moved by hand, and set-points begin where it is
    led.arm.sent = [led.place] * len(led.arm.sent)
    led.arm.now += 1.0
    for _ in range(round(0.1 / PERIOD)):
        led.run(PERIOD)
        np.testing.assert_allclose(led.added, 0.0, atol=1e-9)


def test_it_is_refused_where_the_arm_answers_late():
    late = replace(CONFIG.controller.tension, delay=0.05)
    with pytest.raises(ConfigError, match=r"joint_correction\.gain"):
        with_controller(joint_correction=SETTINGS, tension=late)
    tracking = CONFIG.controller.tracking
    followed = replace(tracking, trocar=replace(tracking.trocar, motion="followed"))
    assert with_controller(tracking=followed).controller.tracking == followed
    with pytest.raises(ConfigError, match=r"tracking\.trocar\.motion"):
        with_controller(tracking=followed, tension=late)
    with_controller(tension=late)


def test_what_is_off_is_not_there():
    arm = YieldingArm()
    assert compensated(arm, CONFIG, lambda: State.MOVING) is arm
    play = replace(CONFIG.controller.tool_play, width=(0.1, 0.1))
    config = with_controller(joint_correction=SETTINGS, tool_play=play)
    both = compensated(arm, config, lambda: State.MOVING)
    assert isinstance(both, PlayCompensation) and isinstance(both._robot, JointCorrection)
