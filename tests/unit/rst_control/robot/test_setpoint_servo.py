# SPDX-License-Identifier: BSD-3-Clause
"""The servo of the simulated robot: smooth course, limits with names, and a stop of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rst_control.config import load_simulation_config
from rst_control.robot.setpoint_servo import Servo, ServoLimits, ServoState
from rst_control.types import JOINTS, Setpoint

SHIPPED = load_simulation_config().simulator.servo
CONFIG = replace(SHIPPED, start_tolerance=0.01)  # so that what happens within it can be seen
LIMITS = ServoLimits(JOINTS, np.full(10, -2.0), np.full(10, 2.0), np.full(10, 1.3))
HOME = np.linspace(-0.5, 0.5, 10)
RATES = np.linspace(-1.0, 1.0, 10)
STILL = np.zeros(10)


def servo() -> Servo:
    return Servo(CONFIG, LIMITS, HOME)


@pytest.fixture
def robot() -> Servo:
    return servo()


def wave(t: float) -> tuple[np.ndarray, np.ndarray]:
    return HOME + RATES * 0.1 * (1 - np.cos(3 * t)), RATES * 0.3 * np.sin(3 * t)


def stream(robot: Servo, duration: float, jitter=lambda k: 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Play the wave at 500 Hz, each set-point late by jitter(k); times and course at 1 kHz."""
    arrivals = [(0.002 * k + jitter(k), 0.002 * k) for k in range(int(duration / 0.002) + 1)]
    times, course = [], []
    for step in range(int(duration * 1000)):
        now = step * 1e-3
        while arrivals and arrivals[0][0] <= now + 1e-9:
            stamp = arrivals.pop(0)[1]
            robot.accept(Setpoint(*wave(stamp), stamp), now)
        times.append(now)
        course.append(robot.course(now)[0])
    return np.array(times), np.array(course)


def play_on(robot: Servo, start: float, duration: float) -> np.ndarray:
    """Course without further set-points, at 1 kHz."""
    return np.array([robot.course(start + k * 1e-3)[0] for k in range(int(duration * 1000))])


def test_without_setpoints_it_holds_where_it_started(robot):
    assert np.array_equal(play_on(robot, 0.0, 0.1)[-1], HOME)
    assert robot.state is ServoState.HOLDING
    assert robot.fault == ""


def test_it_reports_where_it_holds_while_nobody_leads_it(robot):
    assert np.array_equal(robot.rest, HOME)
    stream(robot, 0.3)
    assert robot.rest is None
    stopped = play_on(robot, 0.3, 1.0)[-1]
    np.testing.assert_array_equal(robot.rest, stopped)


def test_the_course_is_the_set_course_played_late():
    times, course = stream(servo(), 1.0)
    asked = np.array([wave(max(t - CONFIG.playout_delay, 0.0))[0] for t in times])
    assert np.abs(course - asked).max() < 1e-9 + 2e-7


def test_jitter_of_arrival_within_the_delay_never_reaches_the_joints():
    rng = np.random.default_rng(3)
    late = rng.uniform(0.0, 0.0019, 1000)
    _, smooth = stream(servo(), 1.0)
    _, jittered = stream(servo(), 1.0, lambda k: late[k])
    assert np.abs(smooth - jittered).max() < 1e-12


def test_when_setpoints_stop_in_motion_it_brakes_within_limits_and_holds_and_says_so(robot):
    stream(robot, 0.5)
    course = play_on(robot, 0.5, 0.5)
    assert robot.state is ServoState.HOLDING
    assert "stopped coming while moving" in robot.fault
    deceleration = np.abs(np.diff(course, n=2, axis=0)).max(axis=0) / 1e-6
    assert (deceleration < np.array(CONFIG.brake_deceleration) * 1.02).all()
    assert np.array_equal(course[-1], course[-200])


def test_while_braking_all_joints_stay_on_one_straight_line(robot):
    stream(robot, 0.5)
    course = play_on(robot, 0.521, 0.4)
    moved = course - course[0]
    direction = moved[-1] / np.linalg.norm(moved[-1])
    assert np.abs(moved - np.outer(moved @ direction, direction)).max() < 1e-12
    assert (np.diff(moved @ direction) >= -1e-15).all()


def test_setpoints_that_end_at_rest_end_without_a_fault(robot):
    for k in range(20):
        robot.accept(Setpoint(HOME, STILL, 0.002 * k), 0.002 * k)
    assert np.allclose(play_on(robot, 0.04, 0.2), HOME, atol=1e-15)
    assert robot.state is ServoState.HOLDING
    assert robot.fault == ""


def test_hold_brakes_without_a_fault_and_older_setpoints_no_longer_count(robot):
    stream(robot, 0.5)
    robot.hold(0.5)
    assert robot.state is ServoState.BRAKING
    rest = play_on(robot, 0.5, 0.5)[-1]
    assert robot.fault == ""
    robot.hold(1.0)
    robot.accept(Setpoint(rest, STILL, 0.999), 1.0)
    assert (robot.state, robot.fault) == (ServoState.HOLDING, "")
    robot.accept(Setpoint(rest, STILL, 1.001), 1.001)
    assert robot.state is ServoState.FOLLOWING


def test_after_a_fault_nothing_moves_until_it_is_cleared_at_rest(robot):
    stream(robot, 0.5)
    robot.fail("made up", 0.5)
    assert not robot.clear_fault()
    rest = play_on(robot, 0.5, 0.5)[-1]
    robot.accept(Setpoint(rest, STILL, 1.0), 1.0)
    assert robot.state is ServoState.HOLDING
    assert robot.fault == "made up"
    assert robot.clear_fault()
    robot.accept(Setpoint(rest, STILL, 1.002), 1.002)
    assert robot.state is ServoState.FOLLOWING


def test_the_first_fault_is_the_one_that_is_kept(robot):
    robot.fail("first", 0.0)
    robot.fail("second", 0.1)
    assert robot.fault == "first"


@pytest.mark.parametrize(
    ("position", "velocity", "words"),
    [
        (np.where(np.arange(10) == 3, 2.1, HOME), STILL, "joint_4 set-point 2.1000 rad"),
        (HOME + 0.02, STILL, "joint_1 starts 0.0200 rad away"),
        (HOME, np.where(np.arange(10) == 6, 2.0, 0.0), "joint_7 set-point speed 2.000 rad/s"),
    ],
)
def test_a_setpoint_no_joint_may_follow_is_a_named_fault_and_moves_nothing(
    robot, position, velocity, words
):
    robot.accept(Setpoint(position, velocity, 0.0), 0.0)
    assert words in robot.fault
    assert np.array_equal(play_on(robot, 0.0, 0.2)[-1], HOME)


@pytest.mark.parametrize("begins", [0.0, 0.5])  # [s]: from rest, and in motion
def test_a_speed_that_changes_faster_than_the_joints_can_is_a_named_fault(begins):
    limits = replace(LIMITS, acceleration=np.full(10, 1.0))
    robot = Servo(CONFIG, limits, HOME)
    stream(robot, begins)
    assert robot.fault == ""
    position, velocity = wave(begins)
    velocity[6] += 0.004
    robot.accept(Setpoint(position, velocity, begins), begins)
    assert "joint_7 set-point acceleration 2." in robot.fault
    assert "allowed 1.00" in robot.fault


def test_a_jump_between_setpoints_is_a_fault_and_brakes_on_the_old_course(robot):
    stream(robot, 0.5)
    before = robot.course(0.499)[0]
    position, velocity = wave(0.502)
    robot.accept(Setpoint(position + 0.05, velocity, 0.502), 0.5)
    assert "speed" in robot.fault
    course = play_on(robot, 0.5, 0.5)
    assert np.abs(course - before).max() < 0.03


def test_late_setpoints_are_ignored_and_those_of_another_clock_are_a_named_fault(robot):
    robot.accept(Setpoint(HOME + 0.005, STILL, 2.0 - CONFIG.lead), 2.0)
    assert (robot.state, robot.fault) == (ServoState.HOLDING, "")
    robot.accept(Setpoint(HOME, STILL, 3.0), 2.0)
    assert "set-point stamped 1.000 s in the future" in robot.fault
    assert robot.clear_fault()
    robot.accept(Setpoint(HOME + 0.005, STILL, 1.0), 2.0)
    assert "set-point stamped 1.000 s in the past" in robot.fault
    assert np.array_equal(play_on(robot, 2.0, 0.2)[-1], HOME)


@pytest.mark.parametrize("behind", [1.5 * CONFIG.stale_after, 0.99 * CONFIG.lead])
def test_a_clock_that_is_a_little_behind_is_named_once_all_of_its_setpoints_came_late(behind):
    robot, now = servo(), 2.0
    while not robot.fault and now < 3.0:
        assert np.array_equal(robot.course(now)[0], HOME)
        robot.accept(Setpoint(HOME, STILL, now - behind), now)
        now += CONFIG.period
    assert f"set-points stamped {behind:.3f} s in the past for 0.15 s" in robot.fault
    assert f"allowed {CONFIG.stale_after:.3f} s" in robot.fault


def test_setpoints_that_are_late_now_and_then_are_no_fault(robot):
    late = 2.0 * CONFIG.stale_after
    for now in np.arange(2.0, 6.0, 0.5):  # one by one
        robot.accept(Setpoint(HOME, STILL, now - late), now)
    now = 6.0
    while now < 8.0:  # between those that are in time
        robot.accept(Setpoint(HOME, STILL, now - late), now)
        robot.accept(Setpoint(HOME, STILL, now), now)
        robot.course(now)
        now += CONFIG.period
    assert robot.fault == ""


@pytest.mark.parametrize(("share", "is_taken"), [(1.0 + 2e-6, True), (1.005, False)])
def test_a_plan_at_the_speed_limit_may_pass_it_by_rounding_and_no_more(robot, share, is_taken):
    rate = np.eye(10)[6] * LIMITS.speed[6] * share
    for k in range(50):
        stamp = CONFIG.period * k
        robot.accept(Setpoint(HOME + rate * stamp, rate, stamp), stamp)
    assert (robot.fault == "") is is_taken, robot.fault


def test_a_motion_goes_on_past_a_setpoint_from_long_ago(robot):
    stream(robot, 0.5)
    robot.accept(Setpoint(HOME, STILL, 0.498 - CONFIG.lead), 0.5)
    assert (robot.state, robot.fault) == (ServoState.FOLLOWING, "")


def test_a_course_that_heads_into_a_limit_ends_at_the_limit():
    edge = Servo(CONFIG, LIMITS, np.full(10, 1.999))
    for k in range(3):
        stamp = 0.002 * k
        point = Setpoint(np.full(10, 1.999) + 0.1 * stamp, np.full(10, 0.1), stamp)
        edge.accept(point, stamp)
    assert play_on(edge, 0.006, 0.3).max() == 2.0


@settings(max_examples=60)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["set-point", "wild", "hold", "fail", "clear", "silence"]),
            st.integers(0, 2**32 - 1),
        ),
        max_size=60,
    )
)
@example([("set-point", 0)] * 4 + [("silence", 0)])  # the newest stamp, but for a rounding
def test_whatever_comes_the_course_never_leaves_position_or_speed_limits(events):
    robot, now, last = servo(), 0.0, HOME
    for kind, seed in events:
        rng = np.random.default_rng(seed)
        if kind == "set-point":
            robot.accept(Setpoint(last, rng.uniform(-0.3, 0.3, 10), now), now)
        elif kind == "wild":
            robot.accept(Setpoint(rng.normal(0, 2, 10), rng.normal(0, 2, 10), now), now)
        elif kind == "hold":
            robot.hold(now)
        elif kind == "fail":
            robot.fail("made up", now)
        elif kind == "clear":
            robot.clear_fault()
        for _ in range(40 if kind == "silence" else 2):
            now += 1e-3
            position = robot.course(now)[0]
            assert (np.abs(position - last) <= LIMITS.speed * 1.5e-3 + 1e-12).all()
            assert (np.abs(position) <= 2.0 + 1e-9).all()
            last = position


AWAY = np.array([0.009, -0.009, 0.004, 0.0, 0.001, 0.009, -0.002, 0.009, 0.0, -0.009])  # [rad]


def set_off(robot: Servo, away: np.ndarray, count: int = 250) -> np.ndarray:
    """Course at 1 kHz while set-points stand still, away from where the robot holds."""
    course = [robot.course(0.999)[0]]
    for k in range(2 * count):
        now = 1.0 + k * 1e-3
        if k % 2 == 0:
            robot.accept(Setpoint(HOME + away, STILL, now), now)
        course.append(robot.course(now)[0])
    return np.array(course)


def test_a_first_setpoint_away_from_where_it_holds_is_reached_slowly(robot):
    course = set_off(robot, AWAY)
    speed = np.abs(np.diff(course, axis=0)).max(axis=0) / 1e-3
    assert (speed <= 0.101 * LIMITS.speed).all()
    assert np.abs(course[-1] - HOME - AWAY).max() < 1e-9
    assert robot.fault == ""


def test_its_velocities_are_those_of_its_positions():
    robot, positions, velocities = servo(), [], []
    for k in range(300):
        now = 1.0 + k * 1e-3
        robot.accept(Setpoint(HOME + AWAY, STILL, now), now)
        position, velocity = robot.course(now)
        positions.append(position)
        velocities.append(velocity)
    change = np.diff(positions, axis=0) / 1e-3
    middle = 0.5 * (np.array(velocities)[1:] + np.array(velocities)[:-1])
    assert np.abs(change - middle).max() < 2e-3


@pytest.mark.parametrize("count", [1, 5, 20, 60])
def test_a_course_that_ends_on_the_way_to_it_ends_there_without_a_jump(robot, count):
    before = set_off(robot, AWAY, count)
    after = play_on(robot, 1.0 + 2 * count * 1e-3, 0.5)
    course = np.vstack([before, after])
    assert (np.abs(np.diff(course, axis=0)).max(axis=0) / 1e-3 <= 0.101 * LIMITS.speed).all()
    assert robot.state is ServoState.HOLDING
    assert np.abs(course[-1] - HOME - AWAY).max() < 1e-9
    again = play_on(robot, 2.0, 0.1)
    assert np.array_equal(again, np.tile(course[-1], (100, 1)))


def test_setpoints_that_move_while_the_first_distance_fades_are_followed():
    robot, course = servo(), []
    for k in range(1000):
        now = 1.0 + k * 1e-3
        if k % 2 == 0:
            position, velocity = wave(now - 1.0)
            robot.accept(Setpoint(position + AWAY, velocity, now), now)
        course.append(robot.course(now)[0])
    speed = np.abs(np.diff(course, axis=0)).max(axis=0) / 1e-3
    assert (speed <= 0.301 * np.abs(RATES) + 0.101 * LIMITS.speed).all()
    asked = wave(0.999 - CONFIG.playout_delay)[0] + AWAY
    assert np.abs(course[-1] - asked).max() < 1e-6
