# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.tension.control import TensionControl
from rst_control.tension.grasp_response import GraspResponse
from rst_control.trajectory.motion_profile import MotionBounds, MotionProfile
from rst_control.types import PathState

DT = 0.002
LENGTH = 0.03
BRAKING = 2.0  # [m/s^2]
OVERSHOOT = 0.05  # of the target
STIFFNESSES = (80.0, 200.0, 500.0, 1200.0, 4000.0)  # [N/m], a 50-fold range


class Pull:
    """Tissue that the control pulls: linear, stiffening or viscous, its tension seen late.

    Beyond the tension `bend` it is ten times as stiff; the sensor stays as it is from `dies_at` on.
    """

    def __init__(
        self,
        config,
        stiffness,
        *,
        power=1.0,
        viscous=0.0,
        delay=2,
        s=0.0,
        start_speed=0.0,
        target=1.0,
        bend=None,
        slack=0.0,
        noise=0.0,
        dies_at=None,
    ):
        self._law = stiffness, power, viscous
        self._bend, self._slack, self._dies_at = bend, slack, dies_at
        self._rng = np.random.default_rng(int(stiffness))
        self._noise = lambda: noise * self._rng.normal()
        speed = config.speed
        bounds = MotionBounds(speed.pull_speed, speed.acceleration, speed.jerk)
        self.brakes = MotionBounds(speed.pull_speed, BRAKING, speed.braking_jerk)
        state = PathState(s, start_speed)
        self.control = TensionControl(config.tension, bounds, self.brakes, LENGTH, state, target)
        self._seen = [self.force] * delay
        sensors = config.watchdogs.sensors
        self.response = GraspResponse(config.tension, sensors.tension_deficit)
        self.forces, self.states = [], []

    @property
    def force(self):
        stiffness, power, viscous = self._law
        state = self.control.state
        elastic = stiffness * 0.01 * (max(state.s - self._slack, 0.0) / 0.01) ** power
        if self._bend is not None:
            elastic += 9.0 * max(0.0, elastic - self._bend)
        return max(0.0, elastic + viscous * state.speed)

    def run(self, time=10.0, after=0.3):
        end = None
        for n in range(int(time / DT)):
            seen = max(0.0, self._seen.pop(0) + self._noise())
            self.response.update(len(self.states) * DT, self.control.state.s, seen)
            self.states.append(self.control.step(seen, DT))
            self.forces.append(self.force)
            is_dead = self._dies_at is not None and self.force > self._dies_at
            self._seen.append(self._dies_at if is_dead else self.forces[-1])
            if self.response.objection:
                break
            if end is None and (self.control.is_settled or self.control.is_at_limit):
                end = n + int(after / DT)
            if n == end:
                break
        return np.array(self.forces)


@pytest.fixture
def config(motion_config):
    return motion_config.controller


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("target", [0.3, 1.0, 2.0])
def test_the_target_is_reached_and_held_without_overshoot(config, stiffness, target):
    pull = Pull(config, stiffness, target=target)
    forces = pull.run()
    assert forces.max() <= target * (1 + OVERSHOOT)
    assert abs(forces[-1] - target) <= config.tension.tolerance
    assert np.abs(forces[-100:] - target).max() <= config.tension.tolerance
    assert pull.control.is_settled


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("power", [1.0, 1.7, 2.5])
def test_stiffening_and_viscous_tissue_seen_late_is_not_overpulled(config, stiffness, power):
    pull = Pull(config, stiffness, power=power, viscous=0.003 * stiffness, delay=4)
    forces = pull.run()
    assert forces.max() <= 1.0 + OVERSHOOT
    if pull.control.is_settled:
        assert forces[-1] == pytest.approx(1.0, abs=config.tension.tolerance)


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize(("start", "target"), [(0.3, 2.0), (2.0, 0.3), (0.5, 0.6), (1.0, 1.9)])
def test_a_step_of_any_size_settles_within_half_a_second_beyond_the_travel(
    config, stiffness, start, target
):
    pull = Pull(config, stiffness, s=start / stiffness, target=target, delay=4, noise=0.005)
    forces = pull.run()
    outside = np.flatnonzero(np.abs(forces - target) > config.tension.tolerance)
    travel = abs(target - start) / stiffness / config.speed.pull_speed
    assert outside[-1] * DT <= travel + 0.5
    assert (forces[-1] > start) == (target > start)


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("target", [0.3, 1.0, 2.0])
def test_slack_is_taken_up_without_a_jerk_at_its_end(config, stiffness, target):
    pull = Pull(config, stiffness, target=target, slack=0.004, delay=5, noise=0.005)
    forces = pull.run(time=20.0)
    assert forces.max() <= target * (1 + OVERSHOOT)
    assert abs(forces[-1] - target) <= config.tension.tolerance


@pytest.mark.parametrize("stiffness", [80.0, 200.0, 400.0, 1000.0])
@pytest.mark.parametrize("share", [0.3, 0.6, 0.9, 0.97])
@pytest.mark.parametrize("target", [0.3, 1.0, 2.0])
@pytest.mark.parametrize("delay", [2, 4])
def test_tissue_that_stiffens_tenfold_at_once_never_passes_the_limit(
    config, stiffness, share, target, delay
):
    bend = share * target
    pull = Pull(config, stiffness, bend=bend, target=target, delay=delay, noise=0.005)
    forces = pull.run()
    assert forces.max() < config.tension.limit
    assert abs(forces[-1] - target) <= config.tension.tolerance


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("dies_at", [0.3, 1.0, 1.8])
def test_a_sensor_that_dies_while_pulling_is_noticed_below_the_limit(config, stiffness, dies_at):
    pull = Pull(config, stiffness, target=2.0, dies_at=dies_at)
    forces = pull.run()
    assert "sensor dead" in pull.response.objection.words
    state = pull.control.state
    stop = MotionProfile.braking(state, pull.brakes).end - state.s
    assert forces.max() + stiffness * stop < config.tension.limit


@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_no_objection_is_raised_against_sound_tissue(config, stiffness):
    pull = Pull(config, stiffness, target=2.0, noise=0.005, viscous=0.003 * stiffness)
    pull.run()
    assert pull.response.objection is None


@pytest.mark.parametrize("stiffness", [20.0, 0.0])  # 0: it never pulls back
def test_soft_tissue_ends_at_the_displacement_limit_and_says_so(config, stiffness):
    pull = Pull(config, stiffness, target=1.0)
    pull.run(time=20.0)
    assert pull.control.is_at_limit
    assert not pull.control.is_settled
    positions = [state.s for state in pull.states]
    assert LENGTH - 1e-4 < positions[-1] <= LENGTH + 1e-9
    assert max(positions) <= LENGTH + 1e-9


def test_easing_never_goes_behind_the_grasp(config):
    pull = Pull(config, 100.0, s=0.005, target=-1.0)
    pull.run(time=5.0)
    assert min(state.s for state in pull.states) >= -1e-9


@pytest.mark.parametrize("start_speed", [0.0, 0.01])  # [m/s] of a pull that it takes over from
def test_easing_pulls_only_while_it_still_or_again_goes_forward(config, start_speed):
    control = Pull(config, 100.0, s=0.010, start_speed=start_speed, target=0.5).control
    seen = []
    for _ in range(80):
        state = control.step(100.0 * control.state.s, DT)
        seen.append((state.speed, control.is_pulling))
    assert all(is_pulling == (speed > 0.0) for speed, is_pulling in seen)
    assert seen[-1][0] < 0.0
    for _ in range(3):  # readings below the target
        assert control.step(0.3, DT).speed < 0.0 and not control.is_pulling
    while control.step(0.3, DT).speed < 0.0:
        pass
    assert control.is_pulling


def test_a_pull_that_rests_where_it_may_go_no_further_yet_is_one(config):
    control = Pull(config, 100.0, s=0.005, target=1.0).control
    control.bound = 0.005
    assert control.step(0.5, DT).speed == 0.0
    assert control.is_pulling


def test_speed_acceleration_and_jerk_stay_within_bounds(config):
    pull = Pull(config, 300.0)
    pull.run()
    speeds = np.array([state.speed for state in pull.states])
    accelerations = np.array([state.acceleration for state in pull.states])
    assert np.abs(speeds).max() <= config.speed.pull_speed * 1.001
    assert np.abs(accelerations).max() <= pull.brakes.acceleration * 1.001
    assert np.abs(np.diff(accelerations)).max() <= pull.brakes.jerk * DT * 1.001
    assert accelerations.max() <= config.speed.acceleration * 1.001


def test_a_wider_tolerance_settles_sooner(config):
    times = []
    for tolerance in (0.01, 0.1):
        wider = replace(config, tension=replace(config.tension, tolerance=tolerance))
        pull = Pull(wider, 200.0)
        pull.run(after=0.0)
        times.append(len(pull.forces))
    assert times[1] < times[0]


@pytest.mark.parametrize("slack", np.linspace(0.0, 0.003, 7))
@pytest.mark.parametrize("stiffness", [500.0, 1000.0, 2000.0])
def test_slack_tissue_does_not_teach_that_it_is_soft(config, stiffness, slack):
    pull = Pull(config, stiffness, slack=slack, target=0.31, delay=5, noise=0.005)
    assert pull.run().max() <= 0.31 * (1.0 + OVERSHOOT)
