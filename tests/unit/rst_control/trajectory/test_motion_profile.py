# SPDX-License-Identifier: BSD-3-Clause
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rst_control.trajectory.motion_profile import (
    MotionBounds,
    MotionProfile,
    MotionProfileError,
)
from rst_control.types import PathState

BOUNDS = MotionBounds(0.02, 0.6, 60.0)
DT = 0.002


def run(profile, limit=5.0):
    states = [profile.state]
    while not profile.is_done and len(states) * DT < limit:
        states.append(profile.step(DT))
    return states


def assert_keeps(states, bounds):
    speeds = np.array([state.speed for state in states])
    accelerations = np.array([state.acceleration for state in states])
    assert np.abs(speeds).max() <= bounds.speed * (1 + 1e-9)
    assert np.abs(accelerations).max() <= bounds.acceleration * (1 + 1e-9)
    assert np.abs(np.diff(accelerations)).max() <= bounds.jerk * DT * (1 + 1e-6)


def test_it_goes_to_the_target_within_its_bounds_and_rests_there():
    profile = MotionProfile(PathState(0.0), BOUNDS)
    profile.go_to(0.03)
    states = run(profile)
    assert_keeps(states, BOUNDS)
    assert profile.is_done
    assert states[-1] == PathState(pytest.approx(0.03, abs=1e-12), 0.0, 0.0)
    assert max(state.speed for state in states) == pytest.approx(BOUNDS.speed)


def test_a_new_target_on_the_way_is_taken_up_without_a_jolt():
    profile = MotionProfile(PathState(0.0), BOUNDS)
    profile.go_to(0.01)
    states = [profile.step(DT) for _ in range(100)]
    profile.go_to(0.025)
    states += run(profile)
    assert_keeps(states, BOUNDS)
    assert states[-1].s == pytest.approx(0.025)


def test_a_target_behind_is_reached_by_turning_round():
    profile = MotionProfile(PathState(0.02), BOUNDS)
    profile.go_to(0.03)
    for _ in range(100):
        profile.step(DT)
    profile.go_to(0.02)
    states = run(profile)
    assert states[-1].s == pytest.approx(0.02)
    assert max(state.s for state in states) < 0.03


def test_a_braking_profile_comes_to_rest():
    profile = MotionProfile.braking(PathState(0.01, 0.02, 0.0), BOUNDS)
    states = run(profile)
    assert_keeps(states, BOUNDS)
    assert states[-1].speed == 0.0
    assert states[-1].s == pytest.approx(profile.end)


def test_braking_cuts_an_acceleration_that_still_pushes_on():
    profile = MotionProfile.braking(PathState(0.01, 0.02, 0.1), BOUNDS)
    assert profile.state == PathState(0.01, 0.02, 0.0)
    easing = PathState(0.01, 0.02, -0.1)
    assert MotionProfile.braking(easing, BOUNDS).state == easing


def test_a_profile_without_a_target_does_not_move():
    with pytest.raises(MotionProfileError, match="no target yet"):
        MotionProfile(PathState(0.01, 0.02), BOUNDS).step(DT)


@given(st.floats(0.0, 1.4), st.floats(0.001, 0.03))
def test_braking_at_any_moment_ends_before_the_target_and_as_soon_as_predicted(moment, target):
    profile = MotionProfile(PathState(0.0), BOUNDS)
    profile.go_to(target)
    state = profile.step(moment)
    profile.brake()
    distance = profile.end - state.s
    states = run(profile)
    assert states[-1].s == pytest.approx(state.s + distance, abs=1e-9)
    assert states[-1].s <= target + 1e-9
    assert distance >= 0.0


def test_braking_from_full_speed_takes_speed_over_acceleration_and_its_ramps():
    profile = MotionProfile.braking(PathState(0.0, 0.02, 0.0), BOUNDS)
    ramps = BOUNDS.acceleration / BOUNDS.jerk
    assert profile.remaining == pytest.approx(0.02 / BOUNDS.acceleration + ramps)


def test_a_speed_is_taken_up_and_kept():
    profile = MotionProfile(PathState(0.0), BOUNDS)
    profile.go_at(-0.01)
    states = [profile.step(DT) for _ in range(200)]
    assert_keeps(states, BOUNDS)
    assert states[-1].speed == pytest.approx(-0.01)
    assert states[-1].s < states[-2].s


def test_one_long_step_equals_many_short_ones():
    long, short = (MotionProfile(PathState(0.0), BOUNDS) for _ in range(2))
    long.go_to(0.02)
    short.go_to(0.02)
    for _ in range(150):
        state = short.step(DT)
    assert long.step(150 * DT).s == pytest.approx(state.s, abs=1e-12)


def test_impossible_bounds_are_refused_in_words():
    with pytest.raises(MotionProfileError, match="no profile"):
        MotionProfile(PathState(0.0, 0.1), MotionBounds(0.0, 0.0, 0.0)).go_to(math.nan)
