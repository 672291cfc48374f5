# SPDX-License-Identifier: BSD-3-Clause
"""A stop counts as done by joints that can know of it; until then it is repeated."""

import numpy as np
import pytest

from rst_control.kinova.arm_state import ArmReport, ArmState
from rst_control.kinova.bridge import Lead
from rst_control.kinova.feedback import JointFeedback
from tests.unit.rst_control.kinova.fake_hardware import standing

JUST_BEGUN = 0.08  # [s]: it is led, and does not move yet
SPEED = 0.05  # [rad/s]


def fault_of_the_arm(hardware):
    """The arm says that it has one."""
    hardware.report = ArmReport(ArmState.IN_FAULT, 1, hardware.now)
    hardware.bridge.on_arm_report(hardware.report)


def feedback(hardware, stamp):
    """Of an arm at rest, though it turns by now: what is seen is late."""
    return JointFeedback(hardware.arm.copy(), np.zeros(7), np.zeros(7), stamp)


def test_a_stop_is_repeated_until_joints_that_can_know_of_it_show_rest(hardware, kinova, way):
    hardware.advance(JUST_BEGUN, way)
    fault_of_the_arm(hardware)
    begun, arm = hardware.now, kinova.bridge.arm
    while hardware.bridge.lead is Lead.STOP:
        hardware.advance(0.005)
    assert hardware.now - begun >= arm.lag + 1.0 / arm.feedback_rate
    assert len(hardware.stops) >= 2
    assert hardware.now - begun < 0.5


@pytest.mark.parametrize("lost", [1, 2])
def test_a_stop_that_is_lost_at_the_begin_of_a_motion_is_made_up_for(hardware, way, lost):
    hardware.advance(JUST_BEGUN, way)
    hardware.send_speeds(np.full(7, SPEED))  # as the driver reads it after the stop
    hardware.lost_stops = lost
    hardware.bridge.on_arm(feedback(hardware, hardware.now))
    fault_of_the_arm(hardware)
    hardware.advance(0.5)
    assert len(hardware.stops) > lost
    assert np.abs(hardware.speed).max() == 0.0
    assert hardware.bridge.lead is Lead.NOBODY


def test_rest_that_was_seen_before_the_stop_ends_nothing(hardware, way):
    hardware.advance(JUST_BEGUN, way)
    fault_of_the_arm(hardware)
    hardware.reports_arm = False
    hardware.bridge.on_arm(feedback(hardware, hardware.now))
    hardware.advance(0.05)
    assert hardware.bridge.lead is Lead.STOP


def test_an_arm_that_was_never_led_is_stopped_and_then_led_by_nobody(hardware):
    hardware.bridge.fail("failed on purpose", hardware.now)
    hardware.advance(0.3)
    assert len(hardware.stops) >= 2
    assert hardware.bridge.lead is Lead.NOBODY


def test_bad_set_points_that_go_on_do_not_put_the_end_of_a_stop_off(hardware):
    def bad(_now):
        hardware.bridge.fail("bad set-point", hardware.now)
        return standing(hardware)(_now)

    hardware.advance(0.1, bad)
    leads = []
    hardware.each = lambda: leads.append(hardware.bridge.lead)
    hardware.advance(0.3, bad)
    assert Lead.NOBODY in leads


def test_a_hold_ends_with_zero_velocities_before_the_stop(hardware, way):
    hardware.advance(1.5, way)
    hardware.bridge.hold(hardware.now)
    hardware.offset[0] = 0.001  # made up for, so that what is sent last is not zero
    hardware.advance(1.0)
    sent, velocities = hardware.speeds[-1]
    assert not velocities.any()
    assert sent < hardware.stops[0] <= sent + 0.05
    assert len(hardware.stops) >= 2
    assert hardware.bridge.lead is Lead.NOBODY
