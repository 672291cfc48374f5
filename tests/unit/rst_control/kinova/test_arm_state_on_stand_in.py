# SPDX-License-Identifier: BSD-3-Clause
"""Controller, bridge and the stand-in of the drivers: its own state, and "hey robot"."""

import numpy as np
import pytest

from bench.kinova.rig import KinovaRig, kinova_motion
from rst_control.kinova.arm_state import ArmReport, ArmState, Banks
from rst_control.types import Reason, State

OTHER = 8  # connection of the web page
READY = ArmReport(ArmState.SERVOING_READY, OTHER, 0.0)
TORQUE = ArmReport(ArmState.IN_FAULT, 1, 0.0, joints=(Banks(),) * 3 + (Banks(0x20),))
IN_USE = ArmReport(ArmState.SERVOING_MANUALLY_CONTROLLED, OTHER, 0.0)


@pytest.fixture(scope="module")
def rig():
    with KinovaRig(kinova_motion()) as rig:
        rig.run(0.3)
        rig.home()
        yield rig


@pytest.fixture(autouse=True)
def active(rig):
    """Each begins at rest with an arm that is ready, and the assistance active."""
    at_the_arm(rig, READY)
    assert rig.give("hey robot").reply.result(0).accepted
    yield
    at_the_arm(rig, READY)
    rig.give("hey robot")


def at_the_arm(rig, report):
    rig.drivers.driver.arm.interfere(report, rig.now)
    rig.run(0.3)


def mode(rig):
    return rig.executor.snapshot.mode


def test_a_fault_at_rest_latches_and_hey_robot_clears_it(rig):
    at_the_arm(rig, TORQUE)
    assert mode(rig).state is State.FAULTED
    assert mode(rig).cause.reason is Reason.ARM_FAULT
    assert "joint_4: maximum torque" in mode(rig).reason
    assert not rig.give("tense").reply.result(0).accepted
    assert rig.give("hey robot").reply.result(0).accepted  # the bridge asks the arm to clear it
    assert mode(rig).state is State.ACTIVE


def test_hey_robot_is_refused_while_somebody_else_has_the_arm_and_taken_afterwards(rig):
    at_the_arm(rig, IN_USE)
    assert mode(rig).cause.reason is Reason.ARM_IN_USE
    place = np.array(rig.robot.reading.position)
    reply = rig.give("hey robot").reply.result(0)
    assert not reply.accepted
    assert reply.reason is Reason.ARM_IN_USE
    assert f"connection {OTHER}" in reply.message
    at_the_arm(rig, READY)
    np.testing.assert_allclose(rig.robot.reading.position, place, atol=1e-4)
    assert rig.give("hey robot").reply.result(0).accepted


@pytest.mark.parametrize("state", [ArmState.INITIALIZATION, ArmState.MAINTENANCE])
def test_hey_robot_is_refused_while_the_arm_is_not_ready(rig, state):
    at_the_arm(rig, ArmReport(state, 1, 0.0))
    reply = rig.give("hey robot").reply.result(0)
    assert not reply.accepted
    assert reply.reason is Reason.ARM_NOT_READY
    assert "allowed: servoing ready" in reply.message


def set_off(rig):
    assert rig.give("tense").reply.result(0).accepted
    assert rig.until(lambda: rig.speed > 0.05)


def test_an_emergency_stop_in_motion_is_named_as_one(rig):
    set_off(rig)
    rig.drivers.driver.take_emergency_stop()
    assert rig.until(lambda: mode(rig).state is State.FAULTED, 5.0)
    assert mode(rig).cause.reason is Reason.ARM_FAULT
    assert "base: emergency stop" in mode(rig).reason


@pytest.mark.parametrize("report", [TORQUE, IN_USE], ids=["fault", "in use"])
def test_in_motion_the_arm_rests_and_the_cause_is_named_rightly(rig, report):
    set_off(rig)
    at_the_arm(rig, report)
    assert rig.until(lambda: mode(rig).state is State.FAULTED, 5.0)
    assert mode(rig).cause.reason is report.objection().reason
    rig.run(0.5)
    assert rig.speed < 1e-3
    place = np.array(rig.robot.reading.position)
    at_the_arm(rig, READY)
    rig.run(0.5)
    np.testing.assert_allclose(rig.robot.reading.position, place, atol=1e-4)
