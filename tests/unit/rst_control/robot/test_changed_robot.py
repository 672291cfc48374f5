# SPDX-License-Identifier: BSD-3-Clause
"""What stands between a controller and its robot takes each measurement in once, and passes on."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.robot.sent_changes import ChangedRobot
from rst_control.types import JOINT_COUNT, Measurement, State


class Arm:
    """Says what it is given, and notes what it is asked for."""

    def __init__(self):
        self.measured = None
        self.asked = []

    def measured_js(self):
        return self.measured

    def servo_jp(self, setpoint):
        self.asked.append(setpoint)

    def hold(self):
        self.asked.append("hold")

    def clear_fault(self):
        self.asked.append("clear_fault")


class Counting(ChangedRobot):
    """Adds one second to the stamp of each measurement, once."""

    taken = 0

    def _taken_in(self, measured):
        self.taken += 1
        return replace(measured, stamp=measured.stamp + 1.0)

    def servo_jp(self, setpoint):
        self._robot.servo_jp(setpoint)


def measurement(stamp):
    still = np.zeros(JOINT_COUNT)
    return Measurement(still, still, still, stamp)


@pytest.fixture
def arm():
    return Arm()


@pytest.fixture
def changed(arm):
    return Counting(arm, 0.01, lambda: State.ACTIVE)


def test_nothing_is_measured_before_the_robot_speaks(changed):
    assert changed.measured_js() is None and changed.taken == 0


def test_a_measurement_is_taken_in_once(arm, changed):
    arm.measured = measurement(5.0)
    first = changed.measured_js()
    assert first.stamp == 6.0
    assert changed.measured_js() is first and changed.taken == 1
    arm.measured = measurement(5.002)
    assert changed.measured_js().stamp == 6.002 and changed.taken == 2


def test_hold_and_clear_fault_reach_the_robot_and_what_was_added_stays(arm, changed):
    changed.noted.add(5.0, np.zeros(JOINT_COUNT), 0.0)
    moved = changed.noted.add(5.002, np.full(JOINT_COUNT, 0.001), 0.002)
    assert moved.velocity == pytest.approx(np.full(JOINT_COUNT, 0.5))
    changed.hold()
    changed.clear_fault()
    assert arm.asked == ["hold", "clear_fault"]
    assert changed.noted.newest.position == pytest.approx(moved.position)
    assert changed.noted.newest.velocity == pytest.approx(np.zeros(JOINT_COUNT))
