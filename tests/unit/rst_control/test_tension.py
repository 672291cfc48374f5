# SPDX-License-Identifier: BSD-3-Clause
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rst_control.profile import Bounds
from rst_control.tension import StiffnessEstimate, TensionControl
from rst_control.types import PathState

DT = 0.002
LENGTH = 0.03
OVERSHOOT = 0.05  # of the target
STIFFNESSES = (80.0, 200.0, 500.0, 1200.0, 4000.0)  # [N/m], a 50-fold range


class Pull:
    """Tissue that the control pulls: linear, stiffening or viscous, its tension seen late."""

    def __init__(self, config, stiffness, *, power=1.0, viscous=0.0, delay=2, s=0.0, target=1.0):
        speed = config.speed
        bounds = Bounds(speed.pull_speed, speed.acceleration, speed.jerk)
        self.control = TensionControl(config.tension, bounds, LENGTH, PathState(s), target)
        self._law = stiffness, power, viscous
        self._seen = [self.force] * delay
        self.forces, self.states = [], []

    @property
    def force(self):
        stiffness, power, viscous = self._law
        state = self.control.state
        elastic = stiffness * 0.01 * (max(state.s, 0.0) / 0.01) ** power
        return max(0.0, elastic + viscous * state.speed)

    def run(self, time=10.0, after=0.3):
        end = None
        for n in range(int(time / DT)):
            self.states.append(self.control.step(self._seen.pop(0), DT))
            self.forces.append(self.force)
            self._seen.append(self.forces[-1])
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
@pytest.mark.parametrize("delay", [1, 4])
def test_stiffening_and_viscous_tissue_seen_late_is_not_overpulled(config, stiffness, power, delay):
    pull = Pull(config, stiffness, power=power, viscous=0.003 * stiffness, delay=delay)
    forces = pull.run()
    assert forces.max() <= 1.0 + OVERSHOOT
    if pull.control.is_settled:
        assert forces[-1] == pytest.approx(1.0, abs=config.tension.tolerance)


@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_more_is_always_more_and_less_is_always_less(config, stiffness):
    pull, last = Pull(config, stiffness, target=0.5), 0.0
    last = pull.run()[-1]
    for target in (0.75, 1.0, 1.25, 1.0, 0.75, 0.5):
        pull.control.retarget(target)
        held = pull.run()[-1]
        assert (held > last) == (target > last)
        assert abs(held - target) <= config.tension.tolerance
        last = held


@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_a_step_settles_within_half_a_second(config, stiffness):
    pull = Pull(config, stiffness)
    pull.run()
    pull.control.retarget(1.25)
    before = len(pull.forces)
    forces = pull.run()[before:]
    within = np.abs(forces - 1.25) <= config.tension.tolerance
    assert within[int(0.5 / DT) :].all()


def test_new_targets_while_still_moving_are_followed(config):
    pull = Pull(config, 100.0, target=0.5)
    for target in (0.75, 1.0, 1.25):
        pull.control.retarget(target)
        pull.run(time=0.1)
    assert pull.run()[-1] == pytest.approx(1.25, abs=config.tension.tolerance)


def test_soft_tissue_ends_at_the_displacement_limit_and_says_so(config):
    pull = Pull(config, 20.0, target=1.0)
    pull.run(time=20.0)
    assert pull.control.is_at_limit
    assert not pull.control.is_settled
    positions = [state.s for state in pull.states]
    assert LENGTH - 1e-4 < positions[-1] <= LENGTH + 1e-9
    assert max(positions) <= LENGTH + 1e-9


def test_tissue_that_never_pulls_back_ends_at_the_limit(config):
    pull = Pull(config, 0.0, target=1.0)
    pull.run(time=20.0)
    assert pull.control.is_at_limit


def test_easing_never_goes_behind_the_grasp(config):
    pull = Pull(config, 100.0, s=0.005, target=0.1)
    pull._law = (100.0, 1.0, 0.0)
    pull.control.retarget(-1.0)
    pull.run(time=5.0)
    assert min(state.s for state in pull.states) >= -1e-9


def test_speed_acceleration_and_jerk_stay_within_bounds(config):
    pull = Pull(config, 300.0)
    pull.run()
    speeds = np.array([state.speed for state in pull.states])
    accelerations = np.array([state.acceleration for state in pull.states])
    assert np.abs(speeds).max() <= config.speed.pull_speed * 1.001
    assert np.abs(accelerations).max() <= config.speed.acceleration * 1.001
    assert np.abs(np.diff(accelerations)).max() <= config.speed.jerk * DT * 1.001


def test_the_estimate_starts_stiff_and_finds_the_slope():
    estimate = StiffnessEstimate(20.0, 4000.0)
    assert estimate.value == 4000.0
    for n in range(1000):
        estimate.update(n * 2e-5, 150.0 * n * 2e-5, DT)
    assert estimate.value == pytest.approx(150.0, rel=0.05)


def test_the_estimate_follows_at_once_where_tissue_stiffens():
    estimate = StiffnessEstimate(20.0, 4000.0)
    for n in range(1000):
        estimate.update(n * 2e-5, 100.0 * n * 2e-5, DT)
    force = 100.0 * 999 * 2e-5
    for n in range(1, 10):
        estimate.update((999 + n) * 2e-5, force + 2000.0 * n * 2e-5, DT)
    assert estimate.value == pytest.approx(2000.0, rel=0.1)


def test_a_standing_tip_teaches_nothing():
    estimate = StiffnessEstimate(20.0, 4000.0)
    for n in range(100):
        estimate.update(0.001, 0.01 * n, DT)
    assert estimate.value == 4000.0


def test_a_wider_tolerance_settles_sooner(config):
    times = []
    for tolerance in (0.01, 0.1):
        wider = replace(config, tension=replace(config.tension, tolerance=tolerance))
        pull = Pull(wider, 200.0)
        pull.run(after=0.0)
        times.append(len(pull.forces))
    assert times[1] < times[0]
