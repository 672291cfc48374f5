# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from rst_control.commands.request import Accepted
from rst_control.registration.trocar_context import (
    ActiveTrocarContext,
    TrocarContext,
    TrocarOutOfReach,
)
from rst_control.trajectory.path import Path
from rst_control.types import Reason
from tests.unit.rst_control.support.situations import request, situation

ASIDE = np.array([0.0, 5e-4, 0.0])


@pytest.fixture(scope="module")
def context(robot, motion_config):
    return TrocarContext(motion_config, robot)


def test_the_trocar_is_that_of_the_settings_and_home_is_in_it(
    context, robot, motion_config, joints
):
    np.testing.assert_array_equal(context.trocar, motion_config.scene.trocar)
    shaft = context.shaft(joints)
    assert shaft.error < 1e-9
    assert 0.05 < shaft.insertion < robot.shaft_length


def test_another_trocar_is_another_site_and_the_first_one_stays(context, joints):
    other = context.with_trocar(context.trocar + ASIDE)
    assert other.shaft(joints).error == pytest.approx(5e-4, rel=1e-2)
    assert context.shaft(joints).error < 1e-9
    np.testing.assert_array_equal(other.planner.trocar, context.trocar + ASIDE)
    assert other.config.scene.trocar == tuple(context.trocar + ASIDE)
    assert other.config.scene.home == context.config.scene.home


def test_verification_of_a_site_plans_through_its_trocar(context, joints):
    other = context.with_trocar(context.trocar + ASIDE)
    decision = other.verify(request("tense"), situation(joints))
    assert isinstance(decision, Accepted)
    paths = [phase.path for phase in decision.plan.phases if isinstance(phase.path, Path)]
    seat, *ways = paths
    assert seat.sample(other.model.chain, other.trocar).rcm_error[-1] < 1e-9
    for way in ways:
        assert way.sample(other.model.chain, other.trocar).rcm_error.max() < 1e-6
        assert way.sample(other.model.chain, context.trocar).rcm_error.max() > 4e-4


def test_a_shaft_too_far_from_the_new_trocar_is_refused_by_its_own_verification(context, joints):
    other = context.with_trocar(context.trocar + 4.0 * ASIDE)
    decision = other.verify(request("tense"), situation(joints))
    assert decision.reason is Reason.RCM_TOLERANCE


@pytest.mark.parametrize("trocar", [(1.9, 0.0, 0.0), (0.0, 0.0, -1.7), (1e300, 1e300, 0.0)])
def test_a_trocar_beyond_the_arm_is_refused_with_both_distances(context, trocar):
    with pytest.raises(TrocarOutOfReach, match=r"m from base_link, allowed 0 to 1\.601 m"):
        context.with_trocar(trocar)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), float("-inf")])
def test_a_trocar_that_is_no_point_is_refused(context, bad):
    with pytest.raises(TrocarOutOfReach):
        context.with_trocar((0.4, bad, 0.4))


def test_questions_to_the_present_context_are_answered_by_the_active_one(context, joints):
    present = ActiveTrocarContext(context)
    verify, locate = present.verify, present.trocar_pose
    before = locate(joints).rcm_error
    present.current = context.with_trocar(context.trocar + 4.0 * ASIDE)
    assert before < 1e-9 < locate(joints).rcm_error
    assert verify(request("tense"), situation(joints)).reason is Reason.RCM_TOLERANCE


def test_going_back_into_the_trocar_the_tip_is_no_faster_than_on_any_other_way(context, home):
    other = context.with_trocar(context.trocar + 1.9 * ASIDE)
    speed = other.config.controller.speed.tip_speed
    seat = other.planner.route(home)[0]
    bounds = other.planner.pace(seat, speed).moving
    samples = seat.sample(other.model.chain, other.trocar)
    way = np.linalg.norm(np.diff(samples.tip, axis=0), axis=1) / np.diff(samples.s)
    assert way.max() * bounds.speed <= 1.05 * speed
