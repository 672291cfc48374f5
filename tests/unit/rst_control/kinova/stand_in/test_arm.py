# SPDX-License-Identifier: BSD-3-Clause
"""The stand-in for the arm: speeds, limits, moments at which commands count, torques."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rst_control.kinova.stand_in.arm import ArmRefused
from rst_control.kinova.stand_in.callback_thread import CallbackThread
from rst_control.kinova.stand_in.torque_sensors import TorqueSensors
from rst_control.kinova.stand_in.waypoints import Course, Point, make_waypoints
from tests.unit.rst_control.support.kinova_rig import CONFIG, START, STEP, Rig


def turning(speeds, seconds=0.5, **changes):
    rig = Rig(**changes)
    rig.driver.take_speeds(speeds)
    rig.run(seconds)
    return rig


def test_speeds_go_on_without_anybody_sending_more():
    rig = turning({6: 0.2}, 10.0)
    assert rig.arm.velocity[6] == pytest.approx(0.2)
    assert rig.arm.position[6] - START[6] > 1.9


def test_joints_that_are_not_named_stand():
    rig = turning({6: 0.2})
    rig.driver.take_speeds({0: 0.1})
    rig.run(1.0)
    assert_allclose(rig.arm.velocity, [0.1, 0, 0, 0, 0, 0, 0], atol=1e-12)


def test_zero_speeds_end_the_motion():
    rig = turning({6: 0.2})
    rig.driver.take_speeds(dict.fromkeys(range(7), 0.0))
    rig.run(0.5)
    assert not rig.arm.is_moving
    assert not rig.arm.velocity.any()


def test_speeds_are_held_within_the_arms_own():
    rig = turning({6: 5.0}, 2.0)
    assert rig.arm.velocity[6] == pytest.approx(rig.limits.speed[6])


def test_a_joint_comes_to_rest_at_its_limit_and_stays():
    rig = turning({1: -0.8}, 8.0)
    assert rig.arm.position[1] == pytest.approx(rig.limits.lower[1], abs=1e-3)
    assert rig.arm.velocity[1] == pytest.approx(0.0, abs=1e-2)
    changes = np.diff([v[1] for _, _, v in rig.seen])
    assert np.abs(changes).max() <= rig.limits.acceleration[1] * STEP + 1e-9


def test_no_joint_changes_its_speed_faster_than_it_may():
    rig = turning({0: 0.5, 6: 0.5}, 1.0)
    rig.driver.take_stop()
    rig.run(2.0)
    velocity = np.array([v for _, _, v in rig.seen])
    most = np.abs(np.diff(velocity, axis=0)).max(axis=0) / STEP
    assert (most <= rig.limits.acceleration + 1e-6).all()


def test_an_emergency_stop_brakes_harder_than_a_stop():
    ways = []
    for emergency in (False, True):
        rig = turning({0: 0.5}, 1.0)
        before = rig.arm.position[0]
        rig.driver.take_emergency_stop() if emergency else rig.driver.take_stop()
        rig.run(2.0)
        ways.append(rig.arm.position[0] - before)
    assert ways[1] < 0.6 * ways[0]


@pytest.mark.parametrize("speeds", [{7: 0.1}, {6: float("nan")}, {6: float("inf")}])
def test_speeds_that_make_no_sense_are_refused_and_change_nothing(speeds):
    rig = turning({6: 0.1})
    with pytest.raises(ArmRefused):
        rig.arm.send_speeds(speeds)
    rig.run(0.2)
    assert rig.arm.velocity[6] == pytest.approx(0.1)


def test_commands_count_only_at_the_arms_own_moments():
    period = CONFIG.driver.command_period
    for offset in (0.0, 0.006, 0.018):
        rig = Rig()
        rig.run(1.0 + offset)
        rig.driver.take_speeds({6: 0.1})
        rig.run(0.1)
        begun = rig.first_motion(0.0)
        phase = (begun - STEP) % period
        assert min(phase, period - phase) < 2.0 * STEP


def test_of_each_topic_only_the_newest_message_waits():
    done, thread = [], CallbackThread()

    def work(name, time):
        done.append(name)
        yield time

    thread.post("goal", lambda: work("goal", 1.0), keep_all=True)
    thread.advance(0.0)
    for name in ("stop 1", "speeds 1", "stop 2", "speeds 2"):
        thread.post(name[:-2], lambda name=name: work(name, 0.01))
    thread.advance(0.9)
    assert done == ["goal"]
    thread.advance(1.1)
    assert done == ["goal", "stop 2", "speeds 2"]
    assert not thread.is_busy


def test_durations_are_those_of_the_driver():
    points = [Point((0.0,), 0.7), Point((0.0,), 0.7), Point((0.0,), 0.704), Point((0.0,), 1.0)]
    durations = [w.duration for w in make_waypoints(points, 0.5, 0.01)]
    assert_allclose(durations, [0.5, 0.01, 0.01, 0.296])


def test_the_course_passes_through_all_way_points_smoothly_and_rests_at_its_ends():
    angles = np.cumsum(np.full((8, 7), 0.02), axis=0)
    points = [Point(tuple(q), 0.1 * k) for k, q in enumerate(angles)]
    course = Course(np.zeros(7), make_waypoints(points, 0.5, 0.01))
    for k, q in enumerate(angles):
        assert_allclose(course.at(0.5 + 0.1 * k)[0], q, atol=1e-12)
    assert_allclose(course.at(0.0)[1], 0.0, atol=1e-12)
    assert_allclose(course.at(course.duration + 1.0)[1], 0.0)
    before, after = course.at(0.6 - 1e-6), course.at(0.6 + 1e-6)
    assert_allclose(before[1], after[1], atol=1e-4)


def test_reported_torques_have_offset_noise_and_friction_but_none_of_it_at_rest():
    torque = CONFIG.driver.torque
    sensors, effort = TorqueSensors(torque), np.linspace(-5.0, 5.0, 7)
    resting = np.array([sensors(effort, np.zeros(7)) for _ in range(2000)])
    assert_allclose(resting.mean(axis=0), effort + torque.offset, atol=0.01)
    assert_allclose(resting.std(axis=0), torque.noise, rtol=0.1)
    moving = np.array([sensors(effort, np.full(7, 0.2)) for _ in range(2000)])
    assert_allclose(moving.mean(axis=0) - resting.mean(axis=0), torque.friction, atol=0.02)
