# SPDX-License-Identifier: BSD-3-Clause
"""Without a trusted tension pulls go by distance, as if the tissue were the stiffest expected."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.commands.request import Accepted
from rst_control.commands.verifier import Verifier
from rst_control.kinematics.configuration import robot_joints
from rst_control.supervision.tension_trust import about_gain
from rst_control.types import Reason, Rejected
from tests.support.changed_settings import changed, planner_with
from tests.unit.rst_control.support.situations import request, situation

WHY = "torques fit no pull"


def with_tension(planner, **tension):
    return Verifier(planner_with(planner, tension=tension))


@pytest.fixture(scope="module")
def trusted(planner):
    """A verifier for a robot that measures the tension."""
    return Verifier(planner)


@pytest.fixture(scope="module")
def verify(planner):
    """A verifier for a robot that measures no tension."""
    return with_tension(planner, source="none", blind_stiffness=200.0)


@pytest.fixture(scope="module")
def plan(trusted, home):
    """The plan that grasped: where the tissue is held does not depend on what is measured."""
    return trusted(request("tense"), situation(robot_joints(home, 0.0))).plan


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


def test_steps_are_distances_and_end_at_the_largest_tension_of_the_stiffest_tissue(verify, plan):
    more = verify(request("pull more"), held(plan, 0.005)).plan.phases[-1]
    assert (more.tension, more.target) == (None, pytest.approx(0.005 + 0.25 / 200.0))
    last = verify(request("pull more"), held(plan, 0.00875))
    assert last.plan.phases[-1].target == pytest.approx(0.010)  # 2 N over 200 N/m
    further = verify(request("pull more"), held(plan, 0.0090))
    assert further.reason is Reason.DISPLACEMENT_LIMIT
    assert "allowed 0 to 10.0 mm" in further.words


def test_a_step_in_newtons_becomes_its_distance(verify, plan):
    more = verify(request("pull more", tension=0.5), held(plan, 0.004)).plan.phases[-1]
    assert more.target == pytest.approx(0.004 + 0.5 / 200.0)
    huge = verify(request("pull more", distance=0.007), held(plan, 0.004))
    assert huge.reason is Reason.DISPLACEMENT_LIMIT


def test_pull_less_is_never_refused_for_having_gone_too_far(verify, plan):
    less = verify(request("pull less"), held(plan, 0.015))
    assert less.plan.phases[-1].target == pytest.approx(0.015 - 0.25 / 200.0)
    assert verify(request("pull less"), held(plan, 0.0005)).reason is Reason.DISPLACEMENT_LIMIT


def test_a_tension_that_is_not_trusted_is_not_used(verify, plan):
    """Its slope would forbid the step, were it believed."""
    assert isinstance(verify(request("pull more"), held(plan, 0.002, tension=1.9)), Accepted)


def test_a_sensor_that_is_not_trusted_is_named_with_the_reason(motion_config, trusted, joints):
    words = trusted(request("tense"), situation(joints, tension_invalid_reason=WHY)).plan.words
    assert WHY in words
    plan = trusted(request("tense"), situation(joints)).plan
    assert plan.phases[-1].tension == motion_config.controller.tension.initial


def test_torques_are_judged_once_the_tissue_is_held(motion_config, planner, joints):
    """Their bias is taken at the grasp: before it there is none, and that is no reason."""
    verify = with_tension(planner, source="joint_torque")
    plan = verify(request("tense"), situation(joints, tension_invalid_reason="no tare")).plan
    assert plan.phases[-1].tension == motion_config.controller.tension.initial
    doubted = held(plan, 0.002, tension_invalid_reason=WHY)
    assert verify(request("pull more"), doubted).plan.phases[-1].tension is None
    by_tension = verify(request("pull more"), held(plan, 0.002, tension=0.5)).plan.phases[-1]
    assert by_tension.tension == pytest.approx(0.75)


def test_refusals_of_tension_still_hold(verify, joints):
    assert verify(request("tense", tension=2.2), situation(joints)).reason is Reason.TENSION_LIMIT


def test_the_way_counts_from_where_the_tissue_was_grasped(verify, plan):
    """Not from where a pull was planned anew."""
    near = replace(held(plan, 0.0), pulled=0.008)
    assert verify(request("pull more"), near).plan.phases[-1].target == pytest.approx(0.00125)
    assert verify(request("pull more"), replace(near, pulled=0.0090)).reason is (
        Reason.DISPLACEMENT_LIMIT
    )


def test_where_nobody_saw_the_grasp_nothing_is_pulled_by_distance(verify, plan):
    unseen = replace(held(plan, 0.002), pulled=np.inf)
    refused = verify(request("pull more"), unseen)
    assert refused.reason is Reason.DISPLACEMENT_LIMIT and "release first" in refused.words
    assert isinstance(verify(request("pull less", distance=0.001), unseen), Accepted)
    too_much = verify(request("pull less", distance=0.003), unseen)
    assert too_much.reason is Reason.DISPLACEMENT_LIMIT and "release first" in too_much.words


def test_no_refusal_speaks_of_a_bound_below_nothing(verify, plan):
    beyond = replace(held(plan, 0.0), pulled=0.012)  # 2 mm more than allowed without a tension
    refused = verify(request("pull more"), beyond)
    assert "pulled 13.2 mm, allowed 0 to 10.0 mm" in refused.words
    less = verify(request("pull less"), beyond)
    assert "pulled 10.8 mm, allowed 12.0 to 12.0 mm" in less.words
    within = verify(request("pull more", distance=0.003), replace(beyond, pulled=0.008))
    assert "pulled 11.0 mm, allowed 0 to 10.0 mm" in within.words


@pytest.mark.parametrize("step", [{}, {"distance": 0.005}])
def test_a_pull_that_was_planned_anew_ends_where_the_first_one_would(trusted, plan, step):
    """With a trusted tension, too; else tissue was pulled by the whole path once more."""
    anew = replace(held(plan, 0.010, tension=0.5), grasp=None, pulled=0.010)
    more = trusted(request("pull more", **step), anew).plan.phases[-1]
    assert more.start == 0.0
    assert more.target == pytest.approx(step.get("distance", 0.020), abs=1e-6)
    far = trusted(request("pull more", **step), replace(anew, pulled=0.0296))
    assert far.reason is Reason.DISPLACEMENT_LIMIT
    assert f"pulled {34.6 if step else 30.1} mm, allowed 0 to 30.0 mm" in far.words


@pytest.mark.parametrize("step", [{}, {"distance": 0.001}])
def test_with_a_trusted_tension_nothing_is_pulled_whose_grasp_nobody_saw(trusted, plan, step):
    unseen = replace(held(plan, 0.0, tension=0.5), grasp=None, pulled=np.inf)
    refused = trusted(request("pull more", **step), unseen)
    assert refused.reason is Reason.DISPLACEMENT_LIMIT
    assert refused.words == "nobody saw where the tissue was grasped; release first"


def test_the_last_step_to_the_end_of_the_path_is_taken(trusted, plan):
    """Also where the tip is a hair off its place on the path."""
    near = replace(held(plan, 0.025, tension=0.1), pulled=0.025 + 1e-6)
    last = trusted(request("pull more", distance=plan.grasp.pull.length - 0.025), near)
    assert isinstance(last, Accepted), last


def test_three_steps_back_undo_one_three_times_as_long(verify, plan):
    """0.3 less three times 0.1 is a hair below nothing."""
    s = 0.3e-3
    for _ in range(3):
        decision = verify(request("pull less", distance=0.1e-3), held(plan, s))
        assert isinstance(decision, Accepted), decision
        s = decision.plan.phases[-1].target
    assert s == 0.0


def test_on_soft_tissue_tense_goes_as_far_as_it_may(planner, joints):
    """1 N at 25 N/m are 40 mm: nobody asked for them."""
    verify = with_tension(planner, source="none", blind_stiffness=25.0)
    plan = verify(request("tense"), situation(joints)).plan
    assert plan.phases[-1].target == pytest.approx(0.030)
    assert "pulls 30.0 mm by distance" in plan.words
    asked = verify(request("tense", distance=0.035), situation(joints))
    assert "pulled 35.0 mm, allowed 0 to 30.0 mm" in asked.words


# A tension whose gain nobody has checked may read too little all along.


@pytest.fixture(scope="module")
def unchecked(planner):
    """A verifier where known weights have not been hung on the jaws yet: 12 mm at 200 N/m."""
    return with_tension(planner, gain="unchecked")


def test_with_an_unchecked_gain_no_pull_goes_further_than_the_stiffest_tissue_bears(
    unchecked, joints
):
    plan = unchecked(request("tense"), situation(joints)).plan
    assert plan.phases[-1].target == pytest.approx(0.012)
    assert plan.phases[-1].tension == 1.0
    more = unchecked(request("pull more"), held(plan, 0.010, tension=0.5)).plan.phases[-1]
    assert (more.tension, more.target) == (0.75, pytest.approx(0.012))
    by_way = unchecked(request("pull more", distance=0.002), held(plan, 0.010, tension=0.5))
    assert by_way.plan.phases[-1].target == pytest.approx(0.012)
    for further in (request("pull more"), request("pull more", distance=0.001)):
        refused = unchecked(further, held(plan, 0.0116, tension=0.5))
        assert refused.reason is Reason.DISPLACEMENT_LIMIT
        assert "allowed 0 to 12.0 mm" in refused.words
    assert isinstance(unchecked(request("pull less"), held(plan, 0.012, tension=0.5)), Accepted)
    assert (
        "allowed 0 to 12.0 mm"
        in unchecked(request("tense", distance=0.013), situation(joints)).words
    )


def test_the_way_counts_from_the_grasp_also_where_the_arm_was_pushed_since(unchecked, plan):
    pushed = replace(held(plan, 0.0, tension=0.5), pulled=0.008)
    assert unchecked(request("pull more"), pushed).plan.phases[-1].target == pytest.approx(0.004)
    unseen = replace(pushed, pulled=np.inf)
    refused = unchecked(request("pull more"), unseen)
    assert refused.reason is Reason.DISPLACEMENT_LIMIT
    assert "tension.gain is unchecked" in refused.words and "release first" in refused.words
    assert "release first" in unchecked(request("pull less"), unseen).words
    eased = unchecked(request("pull less"), replace(held(plan, 0.004, tension=0.5), pulled=np.inf))
    assert eased.plan.phases[-1].target == 0.004


@pytest.mark.parametrize(
    ("gain", "length", "words"),
    [
        ("checked", 0.030, "come to 6.0 N, limit 2.4 N"),
        ("unchecked", 0.030, "no pull goes further than 12.0 mm"),
        ("checked", 0.012, ""),
        ("unchecked", 0.012, ""),
    ],
)
def test_what_a_tension_that_reads_too_little_may_do_is_said(motion_config, gain, length, words):
    config = changed(motion_config, tension={"gain": gain}, scene={"max_displacement": length})
    said = about_gain(config)
    assert words in said and bool(words) == bool(said)
