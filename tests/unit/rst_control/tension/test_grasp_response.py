# SPDX-License-Identifier: BSD-3-Clause
"""What tissue may answer to a pull, what it never does, and how far nobody may go without."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rst_control.config import load_motion_config
from rst_control.tension.grasp_response import GraspResponse
from rst_control.types import Reason

PERIOD = 0.002  # [s]
SPEED = 0.01  # [m/s]
CONFIG = load_motion_config().controller.tension
DEFICIT = 0.2  # [N]


class Pull:
    """Tissue that is pulled and rests, and what its sensor says of it."""

    def __init__(self, **changes):
        self.config = replace(CONFIG, **changes)
        self.response = GraspResponse(self.config, DEFICIT)
        self.now, self.s = 0.0, 0.0

    def go(self, way, tension_at, speed=SPEED):
        """Pull on or ease by a way [m], unless an objection comes first."""
        for _ in range(round(abs(way) / speed / PERIOD)):
            self.s += np.sign(way) * speed * PERIOD
            self.update(tension_at)
            if self.response.objection:
                break
        return self

    def rest(self, seconds, tension_at):
        for _ in range(round(seconds / PERIOD)):
            self.update(tension_at)
        return self

    def update(self, tension_at):
        self.now += PERIOD
        self.response.update(self.now, self.s, tension_at(self.s))

    @property
    def words(self):
        return self.response.objection.words if self.response.objection else ""


@pytest.mark.parametrize("stiffness", [80.0, 600.0, 4000.0])
def test_tissue_that_pulls_back_is_not_objected_to(stiffness):
    pull = Pull().go(2.4 / stiffness, lambda s: stiffness * s, speed=2.0 / stiffness)
    assert pull.rest(1.0, lambda s: stiffness * s).words == ""


@settings(max_examples=15)
@given(st.floats(50.0, 600.0), st.floats(0.0, 0.009))
def test_nor_is_tissue_that_stiffens_after_slack(bend, slack):
    def law(s):
        return 0.02 * np.expm1(bend * max(0.0, s - slack))

    way = slack + np.log1p(2.4 / 0.02) / bend
    assert Pull().go(way, law, speed=0.002).words == ""


@pytest.mark.parametrize("stiffness", [80.0, 400.0, 2000.0])
@pytest.mark.parametrize("stuck_at", [0.5, 1.0, 1.9])
def test_a_tension_that_stays_as_it_was_is_noticed_before_much_more_pull(stiffness, stuck_at):
    pull = Pull().go(3.0 / stiffness, lambda s: min(stiffness * s, stuck_at), 0.5 / stiffness)
    assert "sensor dead" in pull.words
    assert pull.response.objection.reason is Reason.NO_RESPONSE_TO_PULL
    assert stiffness * pull.s < stuck_at + 0.3


def test_short_pulls_one_after_the_other_add_up():
    """Each alone is too little to show that the sensor is stuck."""
    rng, truth = np.random.default_rng(1), Pull()

    def law(s):
        return abs(min(200.0 * s, 1.0) + rng.normal(0.0, 0.005))

    truth.go(0.005, law).rest(0.5, law)
    for _ in range(20):
        truth.go(0.0002, law).rest(0.3, law)
    assert truth.words
    assert 200.0 * truth.s < 1.4


def test_an_objection_stays_until_the_next_grasp():
    pull = Pull().go(0.015, lambda s: min(200.0 * s, 1.0))
    assert pull.rest(1.0, lambda s: 200.0 * s).words
    pull.response.grasp()
    assert not pull.response.objection


def test_a_tension_that_falls_at_rest_is_not_believed_any_more():
    pull = Pull().go(0.006, lambda s: 200.0 * s).rest(0.5, lambda s: 1.2)
    assert pull.rest(0.5, lambda s: 1.05).words == ""
    assert "at least" in pull.rest(0.1, lambda s: 0.9).words


@pytest.mark.parametrize("drift", [0.1, 0.2, 0.3])  # [N/s]
def test_falls_at_rest_add_up_though_each_pull_hides_the_one_before(drift):
    """Tissue that stiffens on: no line through earlier readings shows what was lost."""
    pull = Pull()

    def truth(s):
        return 0.13 * np.expm1(300.0 * s)

    def reading(s):
        return truth(s) - drift * max(0.0, pull.now - 1.0)

    pull.go(0.004, reading).rest(0.4, reading)
    while not pull.words and truth(pull.s) < 2.5:
        before = reading(pull.s)
        while reading(pull.s) < before + 0.15 and not pull.words:
            pull.go(2e-5, reading)
        pull.rest(0.4, reading)
    assert "in all while nothing moved, allowed 0.20 N" in pull.words
    assert truth(pull.s) - reading(pull.s) < 0.4


def test_tissue_that_relaxes_in_each_rest_is_believed_up_to_the_deficit_in_all():
    pull, lost = Pull().go(0.004, lambda s: 200.0 * s), [0.0]

    def relaxing(s):
        lost[0] += 0.06 * PERIOD
        return 200.0 * s - lost[0]

    while not pull.words:
        pull.rest(0.5, relaxing).go(0.001, lambda s: 200.0 * s - lost[0])
    assert "in all while nothing moved" in pull.words
    assert 0.12 < lost[0] < 0.25


@pytest.mark.parametrize("speed", [2e-5, 4e-5, 6e-5])  # [m/s]: 0.04 um from reading to reading
def test_tissue_that_is_eased_very_slowly_is_no_drift(speed):
    pull = Pull().go(0.010, lambda s: 200.0 * s).rest(0.5, lambda s: 200.0 * s)
    assert pull.go(-0.0015, lambda s: 200.0 * s, speed).words == ""  # by more than the deficit


def test_a_drift_is_found_at_rests_between_slow_ways():
    pull, since = Pull().go(0.010, lambda s: 100.0 * s), [0.0]

    def drifting(s):
        since[0] += PERIOD
        return 100.0 * s - 0.05 * since[0]

    while not pull.words and since[0] < 10.0:
        pull.go(-2e-5, drifting, speed=2e-5).rest(0.4, drifting)
    assert "at least" in pull.words or "in all while nothing moved" in pull.words
    assert 0.05 * since[0] < 0.3


def test_easing_and_pulling_again_is_not_objected_to():
    def law(s):
        return 200.0 * s

    pull = Pull().go(0.01, law).rest(0.3, law).go(-0.008, law).rest(0.3, law).go(0.009, law)
    assert pull.words == ""


@pytest.mark.parametrize(("held_for", "times"), [(0.5, 120), (120.0, 1)])
def test_a_sensor_with_noise_is_believed_however_long_and_often_tissue_is_held(held_for, times):
    """Of thousands of means at rest a few are off by more than three standard deviations."""
    rng, pull = np.random.default_rng(1), Pull()

    def noisy(s):
        return 200.0 * s + rng.normal(0.0, CONFIG.noise)

    pull.go(0.008, noisy).rest(0.5, noisy)
    for _ in range(times):
        pull.go(-0.004, noisy).rest(held_for, noisy)
        pull.go(0.004, noisy).rest(0.5, noisy)
    assert pull.words == ""


def test_until_a_reading_at_rest_the_pull_ends_where_the_stiffest_tissue_has_its_limit():
    pull = Pull(blind_stiffness=200.0).go(0.004, lambda s: 0.0)
    assert pull.response.room == pytest.approx(2.4 / 200.0 - 0.004, abs=1e-4)
    pull = Pull(blind_stiffness=200.0).go(0.006, lambda s: 80.0 * s)
    assert pull.response.room == pytest.approx(2.4 / 200.0 - 0.006, abs=1e-4)
    pull.rest(0.2, lambda s: 80.0 * s)
    assert pull.response.room == np.inf


def test_a_sensor_that_shows_nothing_there_is_objected_to():
    pull = Pull(blind_stiffness=200.0).go(0.012, lambda s: 0.06).rest(0.3, lambda s: 0.06)
    assert "tension 0.06 N after 12.0 mm of pull" in pull.words


def test_a_sensor_that_is_late_is_found_at_rest():
    past = [0.0] * 150  # 0.3 s

    def late(s):
        past.append(200.0 * s)
        return past.pop(0)

    pull = Pull().go(0.008, late)
    assert pull.words == "" and pull.response.room < 0.0041
    assert "at rest" in pull.rest(0.5, late).words
