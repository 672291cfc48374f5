# SPDX-License-Identifier: BSD-3-Clause
"""A process that did not make the course brakes the arm along it."""

import numpy as np
import pytest

from rst_control.kinova.brake_plan import BrakePlan, LastCourse
from rst_control.kinova.velocity_ramp import Ramp

SPEED = np.array([0.10, -0.14, 0.05, 0.18, 0.04, -0.19, 0.03])  # [rad/s]
STILL = np.zeros(7)
LATE = 0.004  # [rad] of the fastest joint, behind the course


def course(late=0.0, faster=1.0):
    place = late / 0.19 * SPEED
    speeds = faster * SPEED
    return LastCourse(0.0, STILL, speeds, speeds, 0.025 * SPEED + place, SPEED, STILL)


def driven(config, last, delay, times=None):
    """Places [rad] and velocities sent [rad/s] of an arm that does what it is sent."""
    plan = BrakePlan(config, last, delay)
    ramp = Ramp(0.0, last.position, last.velocity, last.sent, np.array(config.arm.acceleration))
    places, sent = [], []
    for now in np.arange(0.0, 1.5, 0.005) if times is None else times:
        places.append(ramp.at(now)[0])
        speeds = plan.step(now)
        if speeds is not None:
            ramp = Ramp(now, *ramp.at(now), speeds, ramp.acceleration)
            sent.append((now, speeds))
    assert plan.is_over
    return np.array(places), sent


def off_line(places):
    line = SPEED / np.linalg.norm(SPEED)
    return np.abs(places - np.outer(places @ line, line)).max()


@pytest.mark.parametrize("last", [course(), course(LATE), course(-LATE), course(LATE, 0.7)])
@pytest.mark.parametrize("delay", [0.025, 0.085])
def test_all_joints_keep_to_their_common_way_and_end_at_rest(kinova, last, delay):
    places, sent = driven(kinova.bridge, last, delay)
    assert off_line(places) < 2e-4
    assert np.abs(sent[-1][1]).max() < 1e-3
    assert np.abs(np.diff(places[-20:], axis=0)).max() < 1e-5


def test_an_arm_behind_its_course_slows_down_at_once(kinova):
    _, sent = driven(kinova.bridge, course(LATE), 0.025)
    rates = [float(np.linalg.norm(speeds)) for _, speeds in sent]
    assert max(rates) <= np.linalg.norm(SPEED) + 1e-6


def test_of_a_process_that_comes_late_no_two_velocities_come_in_short_order(kinova):
    times = [*np.arange(0.0, 0.05, 0.005), *np.arange(0.072, 1.5, 0.005)]
    places, sent = driven(kinova.bridge, course(), 0.025, times)
    assert np.diff([now for now, _ in sent]).min() > 0.7 * kinova.bridge.arm.period
    assert off_line(places) < 2e-4


def test_what_another_process_has_sent_is_passed_over(kinova):
    times = np.cumsum([0.08, *[kinova.bridge.arm.period] * 50])
    _, sent = driven(kinova.bridge, course(), 0.08, times)
    plan = BrakePlan(kinova.bridge, course(), 0.08)
    plan.pass_over(times[4])
    np.testing.assert_allclose(plan.step(times[4]), sent[4][1], atol=1e-9)


def test_an_arm_that_is_not_led_on_stays(kinova):
    still = LastCourse(0.0, STILL, STILL, STILL, STILL, STILL, STILL)
    places, sent = driven(kinova.bridge, still, 0.025)
    assert not places.any()
    assert not any(speeds.any() for _, speeds in sent)
