# SPDX-License-Identifier: BSD-3-Clause
"""Goals of FollowJointTrajectory: what Kinova's driver makes of them, its faults included."""

import numpy as np
import pytest

from tests.unit.rst_control.support.kinova_rig import CONFIG, START, FakeGoal, Rig, move

JOINT = 6


@pytest.fixture
def rig():
    return Rig()


def turn(angle=0.1, time=2.0):
    return FakeGoal((START, 0.0), (move(JOINT, angle), time))


def sent(rig, goal, seconds=0.0):
    rig.driver.take_goal(goal)
    rig.run(seconds)
    return goal


@pytest.mark.parametrize(
    "names",
    [
        CONFIG.driver.joints[:6],
        (*CONFIG.driver.joints, "joint_8"),
        tuple(reversed(CONFIG.driver.joints)),
        (*CONFIG.driver.joints[:5], "joint_7", "joint_6"),
        tuple(f"gen3_{name}" for name in CONFIG.driver.joints),
        (),
    ],
)
def test_other_names_or_another_order_are_rejected_and_move_nothing(rig, names):
    goal = sent(rig, FakeGoal((START, 0.0), (move(JOINT, 0.1), 2.0), names=names), 4.0)
    assert goal.said == ["rejected"]
    assert rig.first_motion() is None


def test_motion_starts_after_the_wait_and_the_first_way_point(rig):
    goal = sent(rig, turn(), 8.0)
    assert goal.said == ["accepted", ("succeeded", 0)]
    least = CONFIG.driver.fault_wait + CONFIG.driver.first_duration
    assert least < rig.first_motion(1e-4) < least + 0.5
    assert rig.arm.position == pytest.approx(move(JOINT, 0.1), abs=1e-9)


def test_velocities_of_points_are_not_even_read():
    assert not hasattr(FakeGoal((START, 0.0)).goal.points[0], "velocities")


def test_a_single_point_is_reached_in_half_a_second_whatever_the_goal_says(rig):
    goal = sent(rig, FakeGoal((move(JOINT, 0.05), 3.0)), 4.0)
    ended = next(t for t, q, _ in rig.seen if abs(q[JOINT] - START[JOINT] - 0.05) < 1e-9)
    assert ended - rig.first_motion() < CONFIG.driver.first_duration + 0.01
    # the driver then finds that it took too little time, and aborts what was reached
    assert goal.said == ["accepted", ("aborted", -4)]


def test_points_at_the_same_time_are_drawn_apart():
    points = [(move(JOINT, 0.0001 * k), 0.0) for k in range(5)]
    rig = Rig()
    goal = sent(rig, FakeGoal(*points), 4.0)
    assert goal.said[-1] == ("succeeded", 0)
    assert rig.arm.position == pytest.approx(points[-1][0])


def test_the_end_position_is_never_checked(rig):
    goal = sent(rig, turn(), 1.5)
    rig.arm._course._end = START.copy()  # the arm ends elsewhere
    rig.run(5.0)
    assert rig.arm.position == pytest.approx(START)
    assert goal.said == ["accepted", ("succeeded", 0)]


def test_another_time_tolerance_of_the_goal_counts(rig):
    goal = FakeGoal((move(JOINT, 0.05), 3.0), time_tolerance=3.5)
    assert sent(rig, goal, 4.0).said == ["accepted", ("succeeded", 0)]


@pytest.mark.parametrize(
    "points",
    [
        [],
        [(START[:6], 0.0)],
        [((*START, 0.0), 0.0)],
        [((*START[:6], float("nan")), 0.0)],
        [(START, 0.0), (move(1, 3.0), 60.0)],  # beyond joint_2's range
        [(START, 0.0), (move(JOINT, 2.0), 1.0)],  # too fast
        [(move(JOINT, 1.0), 0.0)],  # too fast, since the first point has half a second
    ],
)
def test_what_the_arm_does_not_run_is_aborted_without_a_code_and_moves_nothing(rig, points):
    goal = sent(rig, FakeGoal(*points), 4.0)
    assert goal.said == ["accepted", ("aborted", 0)]
    assert rig.first_motion() is None


def test_stop_before_motion_waits_for_the_drivers_thread_and_then_prevents_it(rig):
    goal = sent(rig, turn(), 0.2)
    rig.driver.take_stop()
    rig.run(0.3)
    assert rig.driver.is_moving  # the driver still waits; the stop waits with everything else
    rig.run(4.0)
    assert rig.first_motion() is None
    assert goal.said == ["accepted"]  # nobody answers this goal any more


def test_stop_in_motion_slows_each_joint_down_by_itself_and_aborts_the_goal(rig):
    ends = move(JOINT, 0.6)
    ends[0] += 0.6
    goal = sent(rig, FakeGoal((START, 0.0), (ends, 2.0)), 2.8)
    assert np.abs(rig.arm.velocity).max() > 0.2
    before = rig.arm.position.copy()
    rig.driver.take_stop()
    rig.run(3.0)
    assert not rig.arm.is_moving
    way = rig.arm.position - before
    assert way[0] > 3.0 * way[JOINT]  # the small joint brakes ten times as hard
    assert goal.said == ["accepted", ("aborted", -4)]


def test_a_goal_is_taken_after_a_stop(rig):
    sent(rig, turn(), 2.5)
    rig.driver.take_stop()
    rig.run(1.0)
    here = rig.arm.position.copy()
    goal = sent(rig, FakeGoal((here, 0.0), (START, 2.0)), 6.0)
    assert goal.said == ["accepted", ("succeeded", 0)]
    assert rig.arm.position == pytest.approx(START)


def test_cancel_in_motion_stops_and_is_answered(rig):
    goal = sent(rig, turn(0.4), 2.5)
    goal.ask_cancel()
    rig.driver.take_cancel()
    rig.run(2.0)
    assert goal.said == ["accepted", "canceled"]
    assert 0.0 < rig.arm.position[JOINT] - START[JOINT] < 0.4


def test_cancel_before_motion_is_late_but_comes_before_motion(rig):
    goal = sent(rig, turn(), 0.5)
    goal.ask_cancel()
    rig.driver.take_cancel()
    rig.run(0.6)
    assert goal.said == ["accepted"]  # nothing happens until the arm says that it starts
    rig.run(3.0)
    assert goal.said == ["accepted", "canceled"]
    assert rig.first_motion(1e-3) is None


def test_cancel_is_lost_where_the_arms_notices_overtake_each_other():
    rig = Rig(swapped_notices=True)
    goal = sent(rig, turn(), 0.5)
    goal.ask_cancel()
    rig.driver.take_cancel()
    rig.run(6.0)
    assert rig.arm.position == pytest.approx(move(JOINT, 0.1))  # it went all the way
    assert goal.said == ["accepted"]


def test_swapped_notices_do_no_harm_to_a_goal_that_is_left_alone():
    rig = Rig(swapped_notices=True)
    assert sent(rig, turn(), 6.0).said == ["accepted", ("succeeded", 0)]


def test_a_new_goal_stops_the_old_one_which_nobody_answers(rig):
    old = sent(rig, turn(0.4), 2.5)
    new = sent(rig, FakeGoal((START, 0.0), (move(0, 0.05), 2.0)), 0.2)
    assert not rig.arm.velocity.any()
    rig.run(8.0)
    assert old.said == ["accepted"]
    # the abort of the old motion is reported to the new goal, whose motion is made all the same
    assert new.said == ["accepted", ("aborted", -4)]
    assert rig.arm.position[0] == pytest.approx(START[0] + 0.05)


def test_an_emergency_stop_latches_for_velocities_but_the_next_goal_clears_it_by_itself(rig):
    sent(rig, turn(), 2.5)
    rig.driver.take_emergency_stop()
    rig.run(0.5)
    here = rig.arm.position.copy()
    assert rig.arm.fault == "emergency stop"
    rig.driver.take_speeds({JOINT: 0.1})
    rig.run(0.5)
    assert rig.arm.position == pytest.approx(here)
    goal = sent(rig, FakeGoal((here, 0.0), (START, 2.0)), 6.0)
    assert goal.said == ["accepted", ("succeeded", 0)]
    assert rig.arm.fault == ""


def test_clear_faults_lets_velocities_through_again(rig):
    rig.driver.take_emergency_stop()
    rig.run(0.2)
    rig.driver.take_clear_faults()
    rig.run(0.2)
    rig.driver.take_speeds({JOINT: 0.1})
    rig.run(0.5)
    assert rig.arm.position[JOINT] > START[JOINT] + 0.02


def test_goals_wait_for_each_other(rig):
    first, second = turn(0.01), turn(0.02)
    rig.driver.take_goal(first)
    rig.driver.take_goal(second)
    rig.run(0.5)
    assert first.said == ["accepted"]
    assert second.said == []
