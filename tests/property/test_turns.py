# SPDX-License-Identifier: BSD-3-Clause
"""A joint that turns for ever has several angles for one place: no plan may go the long way.

The whole of it is measured by `bench/site/turns.py`; here a few starts are drawn.
"""

import numpy as np
import pytest

from bench.site.turns import Turns
from rst_control.errors import LongWay
from rst_control.kinematics.configuration import Configuration
from rst_control.trajectory.path import Path

STARTS = 6


@pytest.fixture(scope="module")
def turns(planner):
    return Turns(planner)


def test_no_joint_goes_the_long_way_from_any_turn_of_a_start_inside(turns):
    for q in turns.starts(STARTS, seed=5):
        found = turns.from_each_turn(q, turns.reach)
        assert found
        for way in found:
            assert way.excess <= np.pi
            assert way.elbow <= way.elbow_allowed


def test_no_joint_goes_the_long_way_from_any_turn_of_a_start_outside(turns, gate):
    rng = np.random.default_rng(5)
    for _ in range(2):
        q = gate.copy()
        q[[0, 4, 6]] += rng.uniform([-0.3, -0.3, -0.3], [0.0, 0.3, 0.3])
        found = turns.from_each_turn(q, turns.insert)
        assert len(found) > 1
        assert max(way.excess for way in found) <= np.pi


def test_home_written_in_another_turn_plans_the_same_ways(planner, home):
    turned = home.copy()
    turned[6] += 2 * np.pi
    for usual, way in zip(planner.reach(home), planner.reach(turned), strict=True):
        np.testing.assert_allclose(way.end - usual.end, turned - home, atol=1e-2)


def test_a_joint_or_elbow_that_moves_much_further_than_the_tool_is_refused(planner, home):
    def straight(to):
        length = 0.04
        slope = (to - home) / length
        return Path(np.array([home, to]), np.array([slope, slope]), length)

    def refuse(to):
        with pytest.raises(LongWay) as refused:
            planner.checks.detour(straight(to).sample(planner.model.chain, planner.trocar))
        return str(refused.value)

    around, swept = home.copy(), home.copy()
    around[6] += 2 * np.pi
    swept[1] += 1.5
    assert "joint_7 would move by 6.28 rad on a way of 40.0 mm, allowed 3.14 rad" in refuse(around)
    assert "the elbow would move by" in refuse(swept)
    assert "allowed 330 mm" in refuse(swept)


def test_settling_never_turns_a_joint_back_by_a_whole_turn(planner, home):
    pose = Configuration(planner.model, home).T_base_tip
    for joint in (0, 2, 4, 6):
        for turn in (-2 * np.pi, 2 * np.pi):
            q = home.copy()
            q[joint] += turn
            settled = planner.solver.settle(q, pose, planner.trocar).q
            assert np.abs(settled - q).max() < np.pi
