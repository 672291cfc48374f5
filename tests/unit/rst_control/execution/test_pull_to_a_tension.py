# SPDX-License-Identifier: BSD-3-Clause
"""Where a pull to a tension waits, and that one outlying reading neither ends nor unwatches it."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from rst_control.config import load_motion_config
from rst_control.execution.guarded_pull import GuardedPull
from rst_control.execution.phase_execution import TensionPhase
from rst_control.planning.plan import PhaseKind
from rst_control.tension.grasp_response import GraspResponse
from tests.unit.rst_control.support.pulls import PERIOD, measured, start_of

STIFFNESS = 60.0  # [N/m]
TENSION = replace(load_motion_config().controller.tension, delay=0.085, noise=0.02, bandwidth=3.0)
ALLOWED = TENSION.limit / TENSION.blind_stiffness  # [m] before a reading at rest


@pytest.mark.parametrize("kind", [TensionPhase, GuardedPull])
@pytest.mark.parametrize("between", [0.002, 0.025])  # [s] from one reading to the next
def test_it_rests_where_a_reading_must_confirm_it_and_goes_on(kind, between):
    response = GraspResponse(TENSION, 0.2)
    pull = kind(start_of(1.0), TENSION, response)
    places = [0.0] * round(TENSION.delay / PERIOD)
    reading = measured(0.0, 0.0)
    for tick in range(round(30.0 / PERIOD)):
        places.append(pull.state.s)
        tension = STIFFNESS * places.pop(0)
        if tick % round(between / PERIOD) == 0:
            reading = measured(tick * PERIOD, tension)
            response.update(reading.stamp, pull.state.s, reading.tension)
            if response.room < np.inf:
                assert pull.state.s <= ALLOWED + 1e-6
        pull.step(PERIOD, reading)
        if pull.is_done:
            break
    assert pull.is_done
    assert pull.failure is None
    assert STIFFNESS * pull.state.s == pytest.approx(1.0, abs=2.0 * TENSION.tolerance)


class Sensed:
    """Held tissue of 100 N/m that a pull to a tension moves, its readings 8 ms late."""

    stiffness, config = 100.0, load_motion_config().controller.tension

    def __init__(self, goal, start, **changes):
        self.config = replace(self.config, **changes)
        self.response = GraspResponse(self.config, 0.2)
        for tick in range(400):  # from the grasp to where it starts
            s = start * min(1.0, tick / 200)
            self.response.update((tick - 400) * PERIOD, s, self.stiffness * s)
        begin = start_of(goal, start, PhaseKind.STEP)
        self.run = TensionPhase(begin, self.config, self.response)
        self._places, self._now = [start] * 4, 0.0

    @property
    def tension(self):
        return self.stiffness * self.run.state.s

    def tick(self, read=None):
        """Go on by a tick, with what is read in it [N]; None: the tension that was."""
        self._places.append(self.run.state.s)
        true = self.stiffness * self._places.pop(0)
        reading = measured(self._now, true if read is None else read)
        self.response.update(reading.stamp, self.run.state.s, reading.tension)
        self.run.step(PERIOD, reading)
        self._now += PERIOD

    def finish(self):
        """Go on to its end; the course, as places and whether it pulls there."""
        course = []
        while not self.run.is_done and self._now < 20.0:
            self.tick()
            course.append((self.run.state.s, self.run.is_pulling))
        assert self.run.is_done and self.run.failure is None
        return course


@pytest.mark.parametrize("first", [1.0, 1.3, 1.6, 2.3])
def test_a_pull_is_one_whatever_its_first_reading_says(first):
    tissue = Sensed(goal=1.25, start=0.010)
    tissue.tick(first)
    course = tissue.finish()
    ways = [(now[0] - last[0], now[1]) for last, now in pairwise(course)]
    assert sum(way for way, is_pulling in ways if way > 0.0 and is_pulling) > 0.0023
    assert sum(way for way, is_pulling in ways if way > 0.0 and not is_pulling) < 1e-5
    assert tissue.tension == pytest.approx(1.25, abs=0.03)


def test_easing_is_no_pull_until_it_goes_forward_again():
    tissue = Sensed(goal=0.75, start=0.010)
    course = tissue.finish()
    assert not any(is_pulling for _, is_pulling in course[: len(course) // 2])
    assert tissue.tension == pytest.approx(0.75, abs=0.03)


def test_a_pull_from_the_grasp_is_not_done_by_a_first_reading_above_its_goal():
    tissue = Sensed(goal=1.0, start=0.0)
    tissue.tick(1.3)
    assert not tissue.run.is_done
    tissue.finish()
    assert tissue.tension == pytest.approx(1.0, abs=0.03)


def test_a_tension_that_stays_too_high_with_nothing_to_ease_ends_where_it_is():
    tissue = Sensed(goal=1.0, start=0.0)
    for _ in range(round(2.0 * tissue.config.settle_time / PERIOD)):
        tissue.tick(1.3)
    assert tissue.run.is_done and tissue.run.state.s == 0.0


def test_without_a_time_to_settle_it_still_pulls_to_its_goal():
    tissue = Sensed(goal=1.0, start=0.0, settle_time=0.0)
    assert not tissue.run.is_done
    tissue.finish()
    assert tissue.tension == pytest.approx(1.0, abs=tissue.config.tolerance + 0.01)
