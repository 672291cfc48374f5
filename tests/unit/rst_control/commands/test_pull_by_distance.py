# SPDX-License-Identifier: BSD-3-Clause
"""Without a trusted tension pulls go by distance, as if the tissue were the stiffest expected."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rst_control.commands.request import Accepted
from rst_control.commands.verifier import Verifier
from rst_control.kinematics.configuration import robot_joints
from rst_control.planning.planner import Planner
from rst_control.types import Reason, Rejected
from tests.unit.rst_control.support.situations import request, situation

WHY = "torques fit no pull"


@pytest.fixture(scope="module")
def blind(motion_config):
    """A verifier for a robot that measures no tension, and its settings of tension."""
    tension = replace(motion_config.controller.tension, source="none", blind_stiffness=200.0)
    controller = replace(motion_config.controller, tension=tension)
    config = replace(motion_config, controller=controller)
    return config


@pytest.fixture(scope="module")
def verify(blind, robot):
    return Verifier(Planner(robot, blind))


@pytest.fixture
def joints(home):
    return robot_joints(home, 0.0)


def held(plan, s, **more):
    """Tissue held, pulled so far [m]."""
    grasp = replace(plan.grasp, s=s, tension=None)
    joints = robot_joints(grasp.pull.evaluate(s).q, 0.0)
    return situation(joints, grasp=grasp, gripped=True, **more)


def test_tense_pulls_as_far_as_keeps_the_stiffest_tissue_below_the_tension(verify, joints):
    decision = verify(request("tense"), situation(joints))
    assert isinstance(decision, Accepted)
    pull = decision.plan.phases[-1]
    assert pull.tension is None
    assert pull.target == pytest.approx(1.0 / 200.0)
    assert "5.0 mm by distance, for tissue up to 200 N/m" in decision.plan.words
    assert "tension.source is none" in decision.plan.words


def test_tense_takes_a_shorter_pull_and_refuses_a_longer_one(verify, joints):
    short = verify(request("tense", distance=0.002), situation(joints))
    assert short.plan.phases[-1].target == pytest.approx(0.002)
    long = verify(request("tense", distance=0.012), situation(joints))
    assert isinstance(long, Rejected)
    assert long.reason is Reason.DISPLACEMENT_LIMIT
    assert "pulled 12.0 mm, allowed 0 to 5.0 mm" in long.words


def test_steps_are_distances_and_end_at_the_largest_tension_of_the_stiffest_tissue(verify, joints):
    plan = verify(request("tense"), situation(joints)).plan
    more = verify(request("pull more"), held(plan, 0.005)).plan.phases[-1]
    assert (more.tension, more.target) == (None, pytest.approx(0.005 + 0.25 / 200.0))
    last = verify(request("pull more"), held(plan, 0.00875))
    assert last.plan.phases[-1].target == pytest.approx(0.010)  # 2 N over 200 N/m
    further = verify(request("pull more"), held(plan, 0.0090))
    assert further.reason is Reason.DISPLACEMENT_LIMIT
    assert "allowed 0 to 10.0 mm" in further.words


def test_a_step_in_newtons_becomes_its_distance(verify, joints):
    plan = verify(request("tense"), situation(joints)).plan
    more = verify(request("pull more", tension=0.5), held(plan, 0.004)).plan.phases[-1]
    assert more.target == pytest.approx(0.004 + 0.5 / 200.0)
    huge = verify(request("pull more", distance=0.007), held(plan, 0.004))
    assert huge.reason is Reason.DISPLACEMENT_LIMIT


def test_pull_less_is_never_refused_for_having_gone_too_far(verify, joints):
    plan = verify(request("tense"), situation(joints)).plan
    less = verify(request("pull less"), held(plan, 0.015))
    assert less.plan.phases[-1].target == pytest.approx(0.015 - 0.25 / 200.0)
    assert verify(request("pull less"), held(plan, 0.0005)).reason is Reason.DISPLACEMENT_LIMIT


def test_a_tension_that_nobody_trusts_is_not_looked_at(verify, joints):
    """Its slope would forbid the step, were it believed."""
    plan = verify(request("tense"), situation(joints)).plan
    assert isinstance(verify(request("pull more"), held(plan, 0.002, tension=1.9)), Accepted)


def test_a_sensor_that_is_not_trusted_is_told_with_the_reason(motion_config, robot, joints):
    verify = Verifier(Planner(robot, motion_config))
    words = verify(request("tense"), situation(joints, tension_invalid_reason=WHY)).plan.words
    assert WHY in words
    trusted = verify(request("tense"), situation(joints)).plan
    assert trusted.phases[-1].tension == motion_config.controller.tension.initial


def test_torques_are_judged_once_the_tissue_is_held(motion_config, robot, joints):
    """Their bias is taken at the grasp: before it there is none, and that is no reason."""
    tension = replace(motion_config.controller.tension, source="joint_torque")
    controller = replace(motion_config.controller, tension=tension)
    verify = Verifier(Planner(robot, replace(motion_config, controller=controller)))
    plan = verify(request("tense"), situation(joints, tension_invalid_reason="no tare")).plan
    assert plan.phases[-1].tension == tension.initial
    step = verify(request("pull more"), held(plan, 0.002, tension_invalid_reason=WHY)).plan.phases[
        -1
    ]
    assert step.tension is None
    told = verify(request("pull more"), held(plan, 0.002, tension=0.5)).plan.phases[-1]
    assert told.tension == pytest.approx(0.75)


def test_refusals_of_tension_still_hold(verify, joints):
    assert verify(request("tense", tension=2.2), situation(joints)).reason is Reason.TENSION_LIMIT
    assert np.isfinite(verify(request("tense"), situation(joints)).plan.phases[-1].target)


def test_the_way_counts_from_where_the_tissue_was_grasped(verify, joints):
    """Not from where a pull was planned anew."""
    plan = verify(request("tense"), situation(joints)).plan
    near = replace(held(plan, 0.0), pulled=0.008)
    assert verify(request("pull more"), near).plan.phases[-1].target == pytest.approx(0.00125)
    assert verify(request("pull more"), replace(near, pulled=0.0090)).reason is (
        Reason.DISPLACEMENT_LIMIT
    )


def test_where_nobody_saw_the_grasp_nothing_is_pulled_by_distance(verify, joints):
    plan = verify(request("tense"), situation(joints)).plan
    unseen = replace(held(plan, 0.002), pulled=np.inf)
    refused = verify(request("pull more"), unseen)
    assert refused.reason is Reason.DISPLACEMENT_LIMIT and "release first" in refused.words
    assert isinstance(verify(request("pull less", distance=0.001), unseen), Accepted)
