# SPDX-License-Identifier: BSD-3-Clause
"""Set-points in, velocities out: course, trocar, stops, faults and what clears them."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import URDF_FILE
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.kinova.bridge import Lead
from rst_control.kinova.feedback import JointFeedback
from rst_control.kinova.tool import ToolState
from rst_control.tension.gravity_check import RestTorques
from tests.unit.rst_control.kinova.fake_hardware import OPENING, FakeHardware, closing, standing


@pytest.fixture
def errors(hardware, planner):
    """Distances of the shaft from the trocar, of each step [m]."""
    found, place = [], planner.patient.trocar_pose
    hardware.each = lambda: found.append(place(planning_joints(hardware.joints)[0]).error)
    return found


def test_the_arm_follows_the_course_with_the_shaft_in_the_trocar(hardware, way, errors):
    hardware.advance(6.0, way)
    assert hardware.bridge.fault(hardware.now) == ""
    end = robot_joints(way.path.end, OPENING)
    assert np.abs(hardware.joints - end).max() < 1e-4
    assert max(errors) < 100e-6
    assert way.profile.is_done
    assert len(hardware.speeds) == pytest.approx(6.0 / 0.025, abs=2)


def test_another_lag_than_thought_costs_the_trocar_little_and_is_reported(hardware, way, errors):
    hardware.delay = 0.060
    hardware.advance(6.0, way)
    assert hardware.bridge.fault(hardware.now) == ""
    assert max(errors) < 300e-6
    assert hardware.bridge.take_health().lag == pytest.approx(0.065, abs=0.02)


def test_an_arm_that_stands_a_little_elsewhere_is_brought_back(hardware, way):
    hardware.advance(0.5, way)
    hardware.offset[3] = 0.002  # the gears' play, say
    hardware.advance(8.0, way)
    assert hardware.bridge.fault(hardware.now) == ""
    seen = hardware.arm + hardware.offset
    assert np.abs(seen - way.path.end[:7]).max() < 2e-4


def test_at_rest_it_sends_zeros_and_nothing_wanders(hardware, way):
    rng = np.random.default_rng(5)
    still = way(hardware.now - 10.0)
    place = hardware.arm.copy()

    def shake():
        hardware.offset = rng.normal(0.0, 5e-5, 7)

    hardware.each = shake
    hardware.advance(5.0, lambda now: still)
    assert np.abs(hardware.arm - place).max() < 3e-4
    assert np.abs([speed for _, speed in hardware.speeds]).max() < 5e-3


def test_a_blocked_joint_stops_the_arm_by_name(hardware, way):
    hardware.advance(1.0, way)
    fastest = int(np.abs(hardware.speed).argmax())
    hardware.blocked = {fastest}
    hardware.advance(3.0, way)
    assert f"joint_{fastest + 1}" in hardware.bridge.fault(hardware.now)
    assert "allowed 0.0200" in hardware.bridge.fault(hardware.now)
    assert hardware.stops
    assert np.abs(hardware.speed).max() == 0.0


def test_old_feedback_brakes_the_arm_along_its_course_then_stops_it(hardware, way, errors):
    hardware.advance(1.0, way)
    assert np.abs(hardware.speed).max() > 0.0
    hardware.reports_arm = False
    hardware.advance(0.1, way)
    assert "joints of the arm" in hardware.bridge.fault(hardware.now)
    assert not hardware.stops  # the driver's own stop would take the shaft off the trocar
    hardware.advance(0.9, way)
    assert len(hardware.stops) > 5  # repeated: nobody knows whether the arm rests
    assert hardware.stops[0] > hardware.speeds[-1][0]
    assert np.abs(hardware.speed).max() == 0.0
    assert max(errors) < 100e-6


def test_a_state_that_comes_once_more_after_a_gap_is_none(hardware, way):
    hardware.advance(1.0, way)
    stale = JointFeedback(hardware.arm.copy(), hardware.speed.copy(), np.zeros(7), hardware.now)
    hardware.bridge.on_arm(stale)
    hardware.reports_arm = False
    hardware.advance(0.2, way)
    again = JointFeedback(stale.position, stale.velocity, stale.effort, hardware.now)
    hardware.bridge.on_arm(again)
    assert hardware.bridge.measured.stamp == stale.stamp
    fresh = JointFeedback(stale.position + 1e-9, stale.velocity, stale.effort, hardware.now)
    hardware.bridge.on_arm(fresh)
    assert hardware.bridge.measured.stamp == hardware.now


def test_set_points_that_end_slow_it_down_along_its_curve_and_latch(hardware, way, errors):
    hardware.advance(1.5, way)
    hardware.advance(1.0)
    assert "set-points stopped coming" in hardware.bridge.fault(hardware.now)
    assert np.abs(hardware.speed).max() == 0.0
    assert hardware.stops
    assert max(errors) < 300e-6
    place = hardware.arm.copy()
    hardware.advance(0.5, way)
    assert np.array_equal(hardware.arm, place)


def test_set_points_more_sudden_than_the_arm_are_refused_and_the_shaft_stays(hardware, way, errors):
    hardware.advance(1.5, way)
    begun = hardware.now

    def sudden(now):
        position, velocity = way(now)
        position[3] += 0.5 * 8.0 * (now - begun) ** 2
        velocity[3] += 8.0 * (now - begun)  # up to 0.4 rad/s within 50 ms
        return position, velocity

    hardware.advance(1.0, sudden)
    fault = hardware.bridge.fault(hardware.now)
    assert "joint_4 set-point acceleration" in fault
    assert "allowed 1.00" in fault
    assert np.abs(hardware.speed).max() == 0.0
    assert max(errors) < 300e-6


def test_a_hold_ends_at_rest_and_set_points_may_follow(hardware, way):
    hardware.advance(1.5, way)
    hardware.bridge.hold(hardware.now)
    hardware.advance(1.0)
    assert hardware.bridge.fault(hardware.now) == ""
    assert np.abs(hardware.speed).max() == 0.0
    assert hardware.bridge.take_health().lead is Lead.NOBODY
    hardware.advance(0.5, standing(hardware))
    assert hardware.bridge.take_health().lead is Lead.COURSE


def test_a_fault_clears_at_rest_only_and_asks_the_arm_to_clear_its_own(hardware, way):
    hardware.advance(1.5, way)
    hardware.bridge.fail("failed on purpose", hardware.now)
    hardware.bridge.clear_fault(hardware.now)
    assert hardware.bridge.fault(hardware.now) == "failed on purpose"
    assert hardware.clears == 0
    hardware.advance(1.0)
    hardware.bridge.clear_fault(hardware.now)
    assert hardware.bridge.fault(hardware.now) == ""
    assert hardware.clears == 1
    hardware.bridge.clear_fault(hardware.now)
    assert hardware.clears == 1


def test_nothing_moves_before_guard_and_tool_are_there(kinova, hardware, way):
    for spoil, words in (
        (lambda h: setattr(h, "guards", False), "stop guard"),
        (lambda h: h.bridge.tool.update_state(ToolState.CONNECTED.value), "not homed"),
        (lambda h: h.bridge.tool.update_state(ToolState.READY.value), "needed: POSITION_CONTROL"),
        (lambda h: setattr(h, "reports_tool", False), "joints of OpenRST"),
        (lambda h: setattr(h, "reports_arm", False), "joints of the arm"),
    ):
        one = FakeHardware(hardware.joints)
        one.ready(kinova)
        spoil(one)
        one.advance(0.2)
        one.advance(1.0, standing(one))
        assert words in one.bridge.fault(one.now)
        assert one.speeds == []
        assert one.tools == []


@pytest.mark.parametrize("lost", ["guard", "homing", "tool"])
def test_what_is_lost_in_motion_stops_the_arm_and_latches(hardware, way, lost):
    hardware.advance(1.5, way)
    assert np.abs(hardware.speed).max() > 0.0
    if lost == "guard":
        hardware.guards = False
    elif lost == "homing":
        hardware.bridge.tool.update_state(ToolState.CONNECTED.value)
    else:
        hardware.reports_tool = False
    hardware.advance(1.0, way)
    assert np.abs(hardware.speed).max() == 0.0
    hardware.guards = hardware.reports_tool = True
    hardware.bridge.tool.update_state(ToolState.POSITION_CONTROL.value)
    hardware.bridge.tool.is_homed = True
    hardware.advance(0.5, way)
    assert hardware.bridge.fault(hardware.now) != ""
    assert np.abs(hardware.speed).max() == 0.0


def test_where_it_ends_is_checked(hardware, way):
    config = replace(hardware.bridge._config.arm, gain=0.0)
    hardware.bridge._follower._config = config
    hardware.advance(0.5, way)
    hardware.offset[4] = 0.005
    hardware.advance(6.0, way)
    assert "joint_5 ended +0.0050 rad off" in hardware.bridge.fault(hardware.now)


def test_a_late_period_is_made_up_for_by_the_next(hardware, way):
    hardware.advance(1.5, way)
    step, hardware.bridge.step = hardware.bridge.step, lambda now: None
    hardware.advance(0.030, way)  # the loop was held up for 30 ms
    hardware.bridge.step = step
    hardware.advance(0.3, way)
    assert hardware.bridge.fault(hardware.now) == ""
    assert hardware.bridge.take_health().latest >= 0.02
    hardware.advance(5.0, way)
    assert np.abs(hardware.joints[:7] - way.path.end[:7]).max() < 1e-4


def test_the_tool_goes_along_with_the_arm_and_within_its_limits(hardware, way, kinova):
    hardware.advance(6.0, way)
    assert hardware.tools[-1][1] == pytest.approx(robot_joints(way.path.end, OPENING)[7:])
    tool = kinova.bridge.tool
    for _, joints in hardware.tools:
        assert (np.array(tool.lower) <= joints).all() and (joints <= np.array(tool.upper)).all()


def test_jaws_that_stay_open_show_that_tissue_is_held(hardware):
    hardware.tissue, close = 0.1, closing(hardware)
    hardware.advance(1.0, close)
    assert hardware.bridge.is_gripped
    assert hardware.bridge.measured.gripped
    hardware.tissue = 0.0  # it slipped
    hardware.advance(0.3, close)
    assert not hardware.bridge.is_gripped


def test_closing_on_nothing_grips_nothing(hardware):
    hardware.advance(1.5, closing(hardware))
    assert not hardware.bridge.is_gripped


def test_tension_that_is_old_is_not_reported(hardware):
    assert hardware.bridge.force(hardware.now) is None
    hardware.bridge.on_force(np.array([0.0, 0.0, 1.0]), hardware.now)
    assert hardware.bridge.force(hardware.now + 0.09) is not None
    assert hardware.bridge.force(hardware.now + 0.11) is None


def test_after_a_fault_the_jaws_stay_sent_to_close_on_the_tissue(hardware):
    q, _ = planning_joints(hardware.joints)
    hardware.tissue = 0.1
    hardware.advance(1.0, closing(hardware))
    hardware.bridge.fail("failed on purpose", hardware.now)
    hardware.advance(1.0)
    assert hardware.bridge.is_gripped
    hardware.bridge.clear_fault(hardware.now)
    closed = robot_joints(q, 0.0)  # what the controller goes on with: it knows that tissue is held
    hardware.advance(1.0, lambda now: (closed, np.zeros(10)))
    assert hardware.bridge.fault(hardware.now) == ""
    assert hardware.bridge.is_gripped
    sent = hardware.tools[-1][1]
    assert sent[1] + sent[2] <= 0.0


def test_it_reports_where_it_holds_the_jaws_on_the_tissue_and_nothing_while_it_is_led(hardware):
    stand, close = hardware.joints, closing(hardware)
    hardware.tissue = 0.1
    seen = []

    def noted(now):
        seen.append(hardware.bridge.measured.sent_to)
        return close(now)

    hardware.advance(1.0, noted)
    np.testing.assert_array_equal(seen[0], stand)
    assert seen[-1] is None
    hardware.advance(1.0)
    measured = hardware.bridge.measured
    assert measured.gripped and planning_joints(measured.position)[1] > 0.09
    assert planning_joints(measured.sent_to)[1] == pytest.approx(0.0, abs=1e-6)


ERRORS = [(0.05, 0.0, 0.0), (0.0, 0.05, -0.05), (-0.1, 0.04, 0.04)]  # [rad] of pitch and jaws


@pytest.mark.parametrize("tissue", [0.0, 0.1])
@pytest.mark.parametrize("error", ERRORS)
def test_faults_in_a_row_do_not_move_a_tool_that_stands_beside_its_command(hardware, error, tissue):
    hardware.tissue, close = tissue, closing(hardware)
    hardware.advance(1.0, close)
    hardware.tool_error = np.array(error)
    hardware.advance(0.2, close)
    sent = hardware.tools[-1][1]
    for _ in range(3):
        hardware.bridge.fail("failed on purpose", hardware.now)
        hardware.advance(1.0)
        hardware.bridge.clear_fault(hardware.now)
        place = hardware.bridge.measured.sent_to  # where the controller goes on from
        hardware.advance(0.2, lambda now, place=place: (place, np.zeros(10)))
        assert hardware.bridge.fault(hardware.now) == ""
    np.testing.assert_allclose(hardware.tools[-1][1], sent, atol=1e-9)


@pytest.mark.parametrize("error", ERRORS)
def test_a_pause_of_set_points_at_rest_is_no_fault_whatever_the_tools_error(hardware, error):
    rest = hardware.joints, np.zeros(10)
    hardware.advance(0.5, lambda _: rest)
    hardware.tool_error = np.array(error)
    hardware.advance(0.5, lambda _: rest)
    hardware.advance(0.4)
    assert hardware.bridge.lead is Lead.NOBODY
    hardware.advance(0.5, lambda _: rest)
    assert (hardware.bridge.lead, hardware.bridge.fault(hardware.now)) == (Lead.COURSE, "")


def test_a_wrist_that_something_holds_elsewhere_is_taken_where_it_is(hardware, kinova):
    rest = hardware.joints, np.zeros(10)
    hardware.advance(0.5, lambda _: rest)
    hardware.bridge.fail("failed on purpose", hardware.now)
    hardware.tool_error[0] = kinova.bridge.tool.following_error + 0.01
    hardware.advance(1.0)
    assert hardware.bridge.measured.sent_to[7] == hardware.joints[7] + hardware.tool_error[0]


def test_an_arm_whose_torques_at_rest_are_not_gravitys_takes_no_set_points(hardware, way, kinova):
    hardware.bridge._ready.torques = RestTorques(kinova.torques, URDF_FILE.read_text("utf-8"), ())
    hardware.advance(1.5, way)  # the fake arm reports no torques at all
    assert "torques at rest do not fit gravity" in hardware.bridge.fault(hardware.now)
    assert not hardware.speeds
