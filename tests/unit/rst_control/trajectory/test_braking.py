# SPDX-License-Identifier: BSD-3-Clause
"""A stop is as hard as the joints allow, and paths are slow enough for it to be short."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rst_control.trajectory.motion_profile import MotionBounds, MotionProfile, stopping_speed
from rst_control.types import PathState, State
from tests.support.changed_settings import planner_with
from tests.unit.rst_control.support.executor_rig import PERIOD, Rig


@given(st.floats(0.02, 4.0), st.floats(20.0, 2000.0), st.floats(0.005, 0.5), st.floats(1e-4, 0.01))
def test_from_the_stopping_speed_braking_keeps_time_and_distance(pull, jerk, time, distance):
    bounds = MotionBounds(0.1, pull, jerk)
    speed = stopping_speed(bounds, time, distance)
    assert speed > 0.0
    brake = MotionProfile.braking(PathState(0.0, speed), bounds)
    assert brake.remaining <= time + 1e-9
    assert brake.end <= distance + 1e-9


def test_a_slow_enough_motion_is_not_slowed_further():
    assert stopping_speed(MotionBounds(0.001, 1.0, 400.0), 0.045, 4.5e-4) == 0.001


@pytest.fixture(params=["hard", "driver_soft"])
def paced(request, planner, home):
    chosen = planner_with(planner, limits={"layer": request.param})
    ways = chosen.reach(home)
    return chosen, [*ways, chosen.pull(ways[-1].end)]


@pytest.mark.parametrize("speed", [0.02, 0.1])
def test_no_joint_brakes_harder_than_it_can_anywhere_on_the_path(paced, speed):
    planner, paths = paced
    for path in paths:
        pace = planner.pace(path, speed)
        samples = path.sample(planner.model.chain, planner.trocar, per_knot=7)
        rate, bend = np.abs(samples.q[:, 1]), np.abs(samples.q[:, 2])
        effort = rate * pace.braking.acceleration + bend * pace.moving.speed**2
        assert (effort <= 1.02 * planner.limits.acceleration).all()


@pytest.mark.parametrize("speed", [0.02, 0.1])
def test_every_path_is_taken_so_slowly_that_it_stops_in_time(paced, speed):
    planner, paths = paced
    layer = planner.config.limits.active
    for path in paths:
        pace = planner.pace(path, speed)
        brake = MotionProfile.braking(PathState(0.0, pace.moving.speed), pace.braking)
        assert pace.moving.speed <= speed
        assert brake.remaining <= layer.stopping_time + 1e-9
        assert brake.end <= layer.stopping_distance + 1e-9


def test_a_stop_is_harder_than_the_motion_and_ends_in_time():
    rig = Rig().moving("reach")
    layer = rig.config.limits.active
    rig.run(0.1)
    stopped, before = rig.now, rig.view.path_position
    rig.stop()
    rig.until(lambda: rig.state is State.HALTED)
    assert rig.now - stopped <= layer.stopping_time + 3 * PERIOD
    moved = rig.view.path_position - before
    assert moved <= layer.stopping_distance + rig.config.controller.speed.tip_speed * PERIOD
