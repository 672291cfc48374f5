# SPDX-License-Identifier: BSD-3-Clause
"""What the arm says of itself: each bit by name, who is in control, soft limits, what latches."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.kinova.arm_state import (
    BASE_FAULTS,
    JOINT_FAULTS,
    ArmReport,
    ArmState,
    Banks,
    SoftLimits,
)
from rst_control.kinova.bridge import Bridge, Lead
from rst_control.types import Reason, robot_fault
from tests.unit.rst_control.kinova.fake_hardware import ACCELERATION, FakeHardware

READY = ArmReport(ArmState.SERVOING_READY, 1, 0.0)
PUBLISHED_BASE = {  # Base.SafetyIdentifier: value and what it names
    0x1: "firmware update failure",
    0x4: "maximum ambient temperature",
    0x10: "joint fault",
    0x100: "too many joints",
    0x1000: "network initialization error",
    0x8000: "minimum voltage",
    0x400000: "maximum payload",
    0x800000: "emergency stop",
    0x1000000: "emergency line",
    0x2000000: "inrush current limiter",
    0x8000000: "incompatible firmware version",
    0x10000000: "power-on self test failure",
}
PUBLISHED_JOINT = {  # ActuatorConfig.SafetyIdentifier
    0x1: "following error",
    0x2: "maximum velocity",
    0x4: "upper joint limit",
    0x8: "lower joint limit",
    0x10: "strain gauge mismatch",
    0x20: "maximum torque",
    0x2000: "maximum motor current",
    0x8000: "maximum voltage",
    0x20000: "maximum motor temperature",
    0x100000: "motor driver",
    0x200000: "emergency line",
    0x800000: "watchdog",
}


def manual(connection):
    """Velocities that one of the connections sends."""
    return ArmReport(ArmState.SERVOING_MANUALLY_CONTROLLED, connection, 0.0)


def says(hardware, report, seconds=0.1, way=None):
    """The fault of the bridge after the arm has said something for a while."""
    hardware.report = report
    hardware.advance(seconds, way)
    return hardware.bridge.fault(hardware.now)


def cause_of(hardware, *said):
    return robot_fault(says(hardware, *said))


@pytest.mark.parametrize(("bit", "name"), PUBLISHED_BASE.items())
def test_a_bit_of_the_base_has_its_published_name(bit, name):
    assert replace(READY, base=Banks(bit)).faults == [f"base: {name}"]


@pytest.mark.parametrize(("bit", "name"), PUBLISHED_JOINT.items())
def test_a_bit_of_a_joint_has_its_published_name(bit, name):
    joints = (Banks(),) * 3 + (Banks(bit),) + (Banks(),) * 3
    assert replace(READY, joints=joints).faults == [f"joint_4: {name}"]


def test_each_known_bit_gives_one_name_of_its_own():
    for known, made in (
        (BASE_FAULTS, lambda bit: replace(READY, base=Banks(1 << bit))),
        (JOINT_FAULTS, lambda bit: replace(READY, joints=(Banks(1 << bit),))),
    ):
        names = [made(bit).faults for bit in range(len(known))]
        assert all(len(one) == 1 for one in names)
        assert len({one[0] for one in names}) == len(known)


@pytest.mark.parametrize(
    ("banks", "words"),
    [
        (Banks(1 << 31), "base: bank A bit 31"),
        (Banks(0, 1), "base: bank B bit 0"),
        (Banks(0, 1 << 31), "base: bank B bit 31"),
    ],
)
def test_a_bit_that_is_published_nowhere_keeps_its_number_and_counts(banks, words):
    report = replace(READY, base=banks)
    assert report.faults == [words]
    assert report.objection().reason is Reason.ARM_FAULT


def test_the_wrist_has_no_published_names():
    assert replace(READY, wrist=Banks(2)).faults == ["wrist: bank A bit 1"]


STATES = {
    ArmState.UNSPECIFIED: Reason.ARM_NOT_READY,
    ArmState.BASE_INITIALIZATION: Reason.ARM_NOT_READY,
    ArmState.IDLE: Reason.ARM_NOT_READY,
    ArmState.INITIALIZATION: Reason.ARM_NOT_READY,
    ArmState.IN_FAULT: Reason.ARM_FAULT,
    ArmState.MAINTENANCE: Reason.ARM_NOT_READY,
    ArmState.SERVOING_LOW_LEVEL: Reason.ARM_IN_USE,
    ArmState.SERVOING_READY: None,
    ArmState.SERVOING_PLAYING_SEQUENCE: Reason.ARM_IN_USE,
    ArmState.SERVOING_MANUALLY_CONTROLLED: Reason.ARM_IN_USE,
    255: Reason.ARM_NOT_READY,
    77: Reason.ARM_NOT_READY,
}


def test_every_state_is_judged():
    assert set(ArmState) <= set(STATES)


@pytest.mark.parametrize(("state", "reason"), STATES.items(), ids=str)
def test_only_an_arm_that_is_ready_may_be_led(hardware, state, reason):
    fault = says(hardware, ArmReport(state, 1, 0.0))
    assert (robot_fault(fault).reason if fault else None) is reason


# On the bridge.


JOINT_4 = ArmReport(
    ArmState.IN_FAULT, 1, 0.0, joints=(Banks(),) * 3 + (Banks(0x20),) + (Banks(),) * 3
)


def test_a_fault_at_rest_latches_and_is_named(hardware):
    says(hardware, JOINT_4)
    cause = cause_of(hardware, READY)
    assert cause.reason is Reason.ARM_FAULT
    assert "joint_4: maximum torque" in cause.words
    assert not hardware.stops  # it rests, and others may have a hand on it


def test_a_fault_that_lasts_is_not_cleared_by_asking_and_is_once_it_is_gone(hardware):
    says(hardware, JOINT_4)
    hardware.bridge.clear_fault(hardware.now)
    assert hardware.clears == 1
    assert "maximum torque" in says(hardware, JOINT_4)
    assert says(hardware, READY) == ""


def test_a_fault_that_lasted_is_cleared_by_asking_again(hardware):
    """The emergency stop was still pressed when "hey robot" was said for the first time."""
    for count in (1, 2):
        says(hardware, JOINT_4)
        hardware.bridge.clear_fault(hardware.now)
        assert hardware.clears == count


def test_an_arm_that_is_in_fault_from_the_start_is_asked_to_clear_it(hardware, kinova):
    arm = FakeHardware(hardware.joints)
    arm.report = JOINT_4
    bridge = Bridge(kinova, arm)
    bridge.on_arm_report(arm.report)  # before any joint state
    bridge = arm.ready(kinova)
    assert "maximum torque" in says(arm, JOINT_4)
    bridge.clear_fault(arm.now)
    assert arm.clears == 1


def test_an_arm_without_a_fault_is_not_asked_to_clear_one(hardware):
    hardware.advance(0.1)
    hardware.bridge.clear_fault(hardware.now)
    assert hardware.clears == 0


def test_a_fault_in_motion_stops_the_arm_at_once_and_is_named_rightly(hardware, way):
    hardware.advance(2.0, way)
    assert hardware.bridge.lead is Lead.COURSE
    hardware.blocked = set(range(7))  # it brakes by itself
    cause = cause_of(hardware, JOINT_4, 0.2, way)
    assert cause.reason is Reason.ARM_FAULT
    assert "joint_4: maximum torque" in cause.words
    assert hardware.stops


def test_velocities_of_the_bridge_itself_are_no_other_hand(hardware, way):
    def report():
        is_led = hardware.bridge.lead is not Lead.NOBODY
        hardware.report = manual(7) if is_led else replace(READY, connection=7)

    hardware.each = report
    hardware.advance(6.0, way)
    assert way.profile.is_done
    assert hardware.bridge.fault(hardware.now) == ""
    hardware.bridge.hold(hardware.now)
    hardware.advance(0.5)
    assert hardware.bridge.fault(hardware.now) == ""


def test_another_connection_that_takes_the_arm_in_motion_stops_it(hardware, way):
    hardware.advance(1.0, way)
    assert says(hardware, manual(7), 0.5, way) == ""
    cause = cause_of(hardware, manual(8), 0.2, way)
    assert cause.reason is Reason.ARM_IN_USE
    assert "connection 8" in cause.words
    assert hardware.stops


def test_velocities_of_the_driver_long_after_a_motion_are_another_hand(hardware, way):
    hardware.advance(1.0, way)
    says(hardware, manual(7), 0.2, way)
    hardware.bridge.hold(hardware.now)
    assert cause_of(hardware, manual(7), 3.0).reason is Reason.ARM_IN_USE


def test_an_arm_that_never_reports_its_state_is_not_led_and_the_setting_is_named(hardware):
    hardware.reports_state = False
    hardware.bridge.watch.report = None
    hardware.advance(0.1)
    cause = robot_fault(hardware.bridge.fault(hardware.now))
    assert cause.reason is Reason.ARM_NOT_READY
    assert "my_gen3/base_feedback" in cause.words
    assert "reports_state: false" in cause.words


def test_a_state_that_ends_is_too_old(hardware):
    hardware.advance(0.1)
    hardware.reports_state = False
    hardware.advance(0.4)
    assert "state is 0." in hardware.bridge.fault(hardware.now)
    assert "allowed 0.25 s" in hardware.bridge.fault(hardware.now)


def without_state(kinova):
    arm = replace(kinova.bridge.arm, reports_state=False, reports_limits=False)
    return replace(kinova, bridge=replace(kinova.bridge, arm=arm))


def test_a_driver_without_a_state_is_led_where_the_setting_says_so(hardware, kinova):
    hardware.reports_state = False
    hardware.ready(without_state(kinova))
    hardware.bridge.watch.limits = None
    hardware.advance(0.2)
    assert hardware.bridge.fault(hardware.now) == ""


def test_after_a_gap_the_limits_are_asked_for_anew(hardware):
    hardware.advance(0.1)
    hardware.reports_state = False
    hardware.advance(0.5)
    hardware.reports_state = True
    hardware.advance(0.1)
    cause = robot_fault(hardware.bridge.fault(hardware.now))
    assert cause.reason is Reason.ARM_LIMITS
    assert "get_kinematic_soft_limits" in cause.words


# Soft limits.


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        (
            SoftLimits(np.full(7, 0.87), ACCELERATION / 2),
            "acceleration of joint_1 is 0.50",
        ),
        (SoftLimits(np.full(7, 0.87), 1.25 * ACCELERATION), "rad/s2, allowed 1.00 to 1.20;"),
        (SoftLimits(np.full(7, 0.2), ACCELERATION), "speed of joint_1 is 0.20 rad/s"),
        (SoftLimits(np.full(6, 0.87), ACCELERATION), "allowed: 7 numbers"),
        (SoftLimits(np.full(7, np.nan), ACCELERATION), "allowed: 7 numbers"),
    ],
)
def test_soft_limits_below_what_is_planned_refuse(hardware, limits, words):
    hardware.bridge.watch.limits = limits
    hardware.advance(0.1)
    cause = robot_fault(hardware.bridge.fault(hardware.now))
    assert cause.reason is Reason.ARM_LIMITS
    assert words in cause.words


def test_soft_limits_that_are_set_in_degrees_are_enough(hardware):
    acceleration = np.radians(np.float32(np.round(np.degrees(ACCELERATION), 1)))
    hardware.bridge.watch.limits = SoftLimits(np.radians(np.full(7, 50.0)), acceleration)
    hardware.advance(0.1)
    assert hardware.bridge.fault(hardware.now) == ""


def test_what_the_arm_says_is_kept_for_the_recording(hardware):
    hardware.report = replace(JOINT_4, warnings=("base: maximum current",))
    hardware.advance(0.1)
    arm = hardware.bridge.take_health().arm
    assert arm["arm: state"] == "in fault"
    assert arm["arm: faults"] == "joint_4: maximum torque"
    assert arm["arm: warnings"] == "base: maximum current"
    assert arm["arm: in control"] == "connection 1"
    assert arm["arm: soft acceleration [rad/s^2]"].startswith("1.00 1.00")


def test_a_bridge_that_heard_nothing_says_so(kinova, hardware):
    assert Bridge(kinova, hardware).watch.words == {"arm: state": "never reported"}
