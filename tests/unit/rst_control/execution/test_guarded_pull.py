# SPDX-License-Identifier: BSD-3-Clause
"""A pull that a rough tension ends: where it stops, how fast it goes, what makes it give up."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rst_control.config import load_motion_config
from rst_control.execution.guarded_pull import GuardedPull
from rst_control.tension.grasp_response import GraspResponse
from tests.unit.rst_control.support.pulls import LENGTH, PERIOD, measured, start_of

TENSION = replace(
    load_motion_config().controller.tension,
    source="joint_torque",
    delay=0.13,
    tolerance=0.15,
    blind_stiffness=200.0,
)
ALLOWED = TENSION.limit / TENSION.blind_stiffness  # [m] before a reading at rest
RESPONSE = GraspResponse(TENSION, 0.8)  # that never hears of a reading


class SpringTissue:
    """Pulled by a run, its tension reported late."""

    def __init__(
        self,
        stiffness: float,
        goal: float,
        start: float = 0.0,
        response: GraspResponse = RESPONSE,
    ) -> None:
        self.run = GuardedPull(start_of(goal, start), TENSION, response)
        self.stiffness, self.now, self.fastest, self.invalid = stiffness, 0.0, 0.0, ""
        self.bias = 0.0  # [N] added to the reading
        self._past = [start] * round(TENSION.delay / PERIOD)

    @property
    def tension(self) -> float:
        return self.stiffness * self.run.state.s

    def misread(self, bias: float, seconds: float = PERIOD) -> None:
        """Pull for a moment in which the sensor is off by a bias [N]."""
        self.bias = bias
        self.pull(seconds)
        self.bias = 0.0

    def finish(self) -> float:
        """Pull to the end; the tension there [N]."""
        self.pull()
        assert self.run.is_done
        return self.tension

    def pull(self, seconds: float = 20.0) -> None:
        for _ in range(round(seconds / PERIOD)):
            self.now += PERIOD
            self._past.append(self.run.state.s)
            reading = self.bias + self.stiffness * self._past.pop(0)
            found = measured(self.now, reading, tension_invalid_reason=self.invalid)
            self.run.step(PERIOD, found)
            self.fastest = max(self.fastest, abs(self.run.state.speed))
            if self.run.is_done:
                return


@pytest.mark.parametrize("stiffness", [50.0, 100.0, 200.0])
def test_it_stops_at_the_tension_asked_for_though_that_is_late(stiffness: float) -> None:
    tissue = SpringTissue(stiffness, goal=1.0)
    assert tissue.finish() == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("when", [0.0, 0.1, 0.5, 1.0])
def test_one_reading_that_is_far_too_high_stops_it_for_a_check_and_no_longer(when: float) -> None:
    tissue = SpringTissue(100.0, goal=1.0)
    tissue.pull(when)
    tissue.misread(1.0)
    tissue.pull(0.2)
    held = tissue.run.state.s
    tissue.pull(0.05)
    assert tissue.run.state.s == held and not tissue.run.is_done
    assert tissue.finish() == pytest.approx(1.0, abs=0.05)


def test_a_tension_that_stays_high_ends_the_pull_where_it_rose() -> None:
    tissue = SpringTissue(100.0, goal=1.0)
    tissue.pull(0.5)
    tissue.bias, before = 1.0, tissue.run.state.s
    tissue.pull()
    assert tissue.run.is_done
    assert tissue.run.state.s - before < 1e-3


def test_a_stop_during_the_check_ends_it() -> None:
    tissue = SpringTissue(100.0, goal=1.0)
    tissue.pull(0.5)
    tissue.misread(1.0)
    tissue.run.brake()
    tissue.pull(0.5)
    assert tissue.run.is_done
    assert tissue.tension < 0.3


def test_easing_that_one_low_reading_stops_goes_on() -> None:
    tissue = SpringTissue(200.0, goal=0.5, start=0.006)
    tissue.pull(0.2)
    tissue.misread(-1.0)
    assert tissue.finish() == pytest.approx(0.5, abs=0.18)


@pytest.mark.parametrize("start", [0.006, 0.009])
def test_easing_goes_on_where_the_first_reading_is_far_too_low(start: float) -> None:
    tissue = SpringTissue(100.0, goal=0.4, start=start)
    tissue.misread(-1.0, 0.025)
    assert tissue.finish() == pytest.approx(0.4, abs=0.1)


@pytest.mark.parametrize("bias", [0.5, -0.5])
def test_with_tissue_held_a_wrong_first_reading_turns_no_pull_round(bias: float) -> None:
    tissue = SpringTissue(100.0, goal=1.0, start=0.006)
    tissue.misread(bias, 0.025)
    assert tissue.finish() == pytest.approx(1.0, abs=0.1)


def test_it_is_so_slow_that_the_stiffest_tissue_rises_by_the_tolerance_within_the_delay() -> None:
    tissue = SpringTissue(100.0, goal=1.0)
    tissue.pull()
    assert tissue.fastest == pytest.approx(0.15 / (0.13 * 200.0), rel=1e-3)
    assert tissue.run.phase.min_time == pytest.approx(LENGTH / tissue.fastest, rel=1e-3)


def test_tissue_five_times_stiffer_than_expected_is_not_pulled_to_twice_the_tension() -> None:
    tissue = SpringTissue(1000.0, goal=1.0)
    assert tissue.finish() < 2.0


def test_it_eases_to_a_lower_tension() -> None:
    tissue = SpringTissue(200.0, goal=0.5, start=0.006)
    tissue.pull()
    assert not tissue.run.is_pulling
    assert tissue.tension == pytest.approx(0.5, abs=0.18)  # the tolerance, and braking


def test_slack_tissue_ends_at_the_end_of_the_path() -> None:
    tissue = SpringTissue(5.0, goal=1.0)
    tissue.pull()
    assert tissue.run.is_done
    assert tissue.run.state.s == pytest.approx(LENGTH)


def test_a_tension_that_loses_trust_ends_the_pull_with_the_reason() -> None:
    tissue = SpringTissue(100.0, goal=1.0)
    tissue.pull(0.3)
    tissue.invalid = "torques fit no pull"
    before = tissue.run.state.s
    tissue.pull()
    assert tissue.run.failure.words == "no trusted tension to pull to: torques fit no pull"
    assert tissue.run.is_done
    assert tissue.run.state.s - before < 1e-3


def test_a_pull_that_begins_where_a_reading_must_confirm_it_rests_there() -> None:
    tissue = SpringTissue(50.0, goal=1.0, start=ALLOWED, response=used_up())
    tissue.pull(0.5)
    assert tissue.run.state.s == pytest.approx(ALLOWED, abs=1e-6)
    assert not tissue.run.is_done
    free = SpringTissue(100.0, goal=1.0, start=0.005)
    free.pull(0.5)
    assert free.run.state.s > 0.006


def test_easing_where_the_pull_began_is_done_at_once() -> None:
    tissue = SpringTissue(100.0, goal=0.5)
    tissue.bias = 0.8
    tissue.pull(1.0)
    assert tissue.run.is_done and not tissue.run.is_pulling
    assert tissue.run.state.s == 0.0


def used_up() -> GraspResponse:
    """Of tissue that was pulled as far as it may be before a reading at rest."""
    response = GraspResponse(TENSION, 0.8)
    response.update(0.0, 0.0, 0.0)
    response.update(PERIOD, ALLOWED, 0.0)
    return response
