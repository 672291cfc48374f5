# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from rst_control.commands.request import Accepted
from rst_control.commands.verifier import Verifier
from rst_control.errors import NearSingular
from rst_control.kinematics import manipulability
from rst_control.types import Reason
from tests.support.changed_settings import planner_with
from tests.unit.rst_control.support.situations import request, situation


def measure(planner, q):
    return manipulability.measure(planner.model.chain, np.array(q), planner.trocar)


def limited(planner, least):
    return planner_with(planner, limits={"min_manipulability": least})


def usual_ways(planner, home):
    reach, last = planner.reach(home)
    return (reach, last, planner.pull(last.end), planner.retreat(last.end))


@pytest.fixture(scope="module")
def least(planner, home):
    """On all the usual ways."""
    return min(measure(planner, knot) for path in usual_ways(planner, home) for knot in path.knots)


@pytest.fixture
def straight(home):
    """The elbow, stretched."""
    return np.where(np.isin(np.arange(9), [1, 3, 5]), 0.0, home)


def test_usual_work_keeps_far_from_singular_postures(planner, least):
    assert least > 4.0 * planner.config.limits.min_manipulability


def test_a_straight_elbow_is_singular_and_a_bent_one_is_not(planner, home, straight):
    assert measure(planner, straight) < 1e-10 < measure(planner, home)


def test_a_way_nearer_to_a_singularity_than_allowed_is_refused_with_both_numbers(
    planner, home, joints, least
):
    strict = limited(planner, 1.05 * least)
    with pytest.raises(NearSingular) as caught:
        usual_ways(strict, home)
    assert caught.value.value == pytest.approx(least, rel=0.01)
    assert caught.value.allowed == 1.05 * least
    decision = Verifier(strict)(request("tense"), situation(joints))
    assert decision.reason is Reason.SINGULAR
    assert f"manipulability {caught.value.value:.2e}, allowed {1.05 * least:.2e}" in decision.words


def test_the_same_way_is_accepted_with_a_limit_just_below_it(planner, joints, least):
    verify = Verifier(limited(planner, 0.95 * least))
    assert isinstance(verify(request("tense"), situation(joints)), Accepted)


def test_a_dip_between_knots_is_found_too(planner, home):
    usual, dip = planner.reach(home)[-1].end, home
    assert measure(planner, dip) < measure(planner, usual)
    allowed = 0.5 * (measure(planner, dip) + measure(planner, usual))
    q = np.tile(usual, (2 * manipulability.STRIDE + 1, 1))
    manipulability.check(planner.model.chain, q, planner.trocar, allowed)
    q[manipulability.STRIDE // 2] = dip
    with pytest.raises(NearSingular):
        manipulability.check(planner.model.chain, q, planner.trocar, allowed)


def test_a_limit_of_zero_refuses_nothing(planner, straight):
    q = np.tile(straight, (3, 1))
    manipulability.check(planner.model.chain, q, planner.trocar, 0.0)
    with pytest.raises(NearSingular):
        manipulability.check(planner.model.chain, q, planner.trocar, 1e-9)


def test_joints_that_are_no_numbers_are_refused(planner, home):
    for place in (0, 10, 20):
        q = np.tile(home, (21, 1))
        q[place, 3] = np.nan
        with pytest.raises(NearSingular):
            manipulability.check(planner.model.chain, q, planner.trocar, 1e-9)
