# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.commands.request import Accepted
from rst_control.commands.table import COMMANDS
from rst_control.commands.verifier import Verifier
from rst_control.kinematics.configuration import robot_joints
from rst_control.planning.plan import PhaseKind
from rst_control.types import Reason, Rejected
from tests.support.changed_settings import planner_with
from tests.unit.rst_control.support.situations import request, situation

STRICT = {"planned_tolerance": 1e-12}  # [m] nearer than a path can keep to


@pytest.fixture
def tensed(verify, joints):
    """The plan that grasped, from which later situations follow."""
    return verify(request("tense"), situation(joints)).plan


def holding(tensed, s=0.01, tension=1.0, target=1.0, **more):
    grasp = replace(tensed.grasp, s=s, tension=target)
    joints = robot_joints(grasp.pull.evaluate(s).q, 0.0)
    return situation(joints, grasp=grasp, gripped=True, tension=tension, **more)


@pytest.fixture
def step(motion_config):
    """Of the tension, by one command [N]."""
    return motion_config.controller.tension.step_tension


def kinds(decision):
    return [phase.kind for phase in decision.plan.phases]


def assert_refused(decision, reason, *words):
    assert isinstance(decision, Rejected)
    assert decision.reason is reason
    for word in words:
        assert word in decision.words


# What each command becomes.


def test_tense_opens_reaches_closes_and_pulls(verify, joints, motion_config):
    decision = verify(request("tense"), situation(joints))
    assert isinstance(decision, Accepted)
    reach = PhaseKind.REACH
    assert kinds(decision) == [PhaseKind.OPEN, reach, reach, PhaseKind.CLOSE, PhaseKind.PULL]
    opening, *_, closing, pull = decision.plan.phases
    assert (opening.path, opening.opening) == (None, motion_config.controller.jaws.open)
    assert (closing.path, closing.opening) == (None, 0.0)
    assert pull.tension == motion_config.controller.tension.initial
    assert pull.target == pytest.approx(motion_config.scene.max_displacement)
    assert decision.plan.grasp.pull is pull.path


def test_every_phase_begins_where_the_one_before_ends(verify, joints, home):
    q = home
    for phase in verify(request("tense"), situation(joints)).plan.phases:
        if phase.path is not None:
            np.testing.assert_allclose(phase.path.evaluate(phase.start).q, q, atol=1e-12)
            q = phase.path.evaluate(phase.target).q


def test_tense_takes_another_tension_and_a_shorter_pull(verify, joints):
    decision = verify(request("tense", tension=0.5, distance=0.012), situation(joints))
    pull = decision.plan.phases[-1]
    assert (pull.tension, pull.target) == (0.5, 0.012)


def test_pull_more_and_pull_less_move_the_target_on_the_same_path(verify, tensed, step):
    for words, sign in (("pull more", 1.0), ("pull less", -1.0)):
        decision = verify(request(words), holding(tensed))
        (phase,) = decision.plan.phases
        assert phase.kind is PhaseKind.STEP
        assert phase.path is tensed.grasp.pull
        assert phase.tension == pytest.approx(1.0 + sign * step)
        assert decision.plan.grasp.tension == phase.tension


def test_said_again_while_moving_each_step_adds_to_the_target(verify, tensed, step):
    moving = holding(tensed, tension=0.4, target=1.25, is_moving=True)
    decision = verify(request("pull more"), moving)
    assert decision.plan.phases[0].tension == pytest.approx(1.25 + step)


def test_at_rest_a_step_starts_from_what_is_measured(verify, tensed, step):
    stopped = holding(tensed, tension=0.6, target=None)
    assert verify(request("pull more"), stopped).plan.phases[0].tension == pytest.approx(0.6 + step)
    soft = holding(tensed, tension=0.6, target=1.0)  # the target was never reached
    assert verify(request("pull less"), soft).plan.phases[0].tension == pytest.approx(0.6 - step)


def test_a_step_of_given_size_is_taken_in_newtons_or_metres(verify, tensed):
    by_force = verify(request("pull more", tension=0.1), holding(tensed)).plan.phases[0]
    assert by_force.tension == pytest.approx(1.1)
    by_way = verify(request("pull less", distance=0.004), holding(tensed)).plan.phases[0]
    assert (by_way.tension, by_way.start) == (None, 0.01)
    assert by_way.target == pytest.approx(0.006)


def test_steps_by_distance_can_be_the_setting(planner, tensed):
    chosen = planner_with(planner, tension={"step_by": "distance", "step_distance": 0.003})
    phase = Verifier(chosen)(request("pull more"), holding(tensed)).plan.phases[0]
    assert phase.target == pytest.approx(0.013)
    most = planner.config.controller.tension.maximum
    assert phase.tension == most  # where it ends, should the tissue be stiff


def test_release_opens_and_goes_out_by_the_ways_known(verify, tensed):
    decision = verify(request("release"), holding(tensed, s=0.01))
    opening, back, out = decision.plan.phases
    assert kinds(decision) == [PhaseKind.OPEN, PhaseKind.EASE, PhaseKind.EASE]
    assert opening.opening > 0.0
    assert (back.path, back.start, back.target) == (tensed.grasp.pull, 0.01, 0.0)
    assert out.path is tensed.grasp.retreat
    assert decision.plan.grasp is None


def test_release_of_tissue_nobody_remembers_plans_a_way_out(verify, tensed):
    forgotten = replace(holding(tensed), grasp=None)
    decision = verify(request("release"), forgotten)
    assert kinds(decision) == [PhaseKind.OPEN, PhaseKind.EASE]
    start = decision.plan.phases[1].path.start
    np.testing.assert_allclose(start, tensed.grasp.pull.evaluate(0.01).q, atol=1e-12)


def test_release_is_never_refused_for_want_of_a_way_out(planner, tensed):
    verify = Verifier(planner_with(planner, scene={"workspace_radius": 0.005}))
    decision = verify(request("release"), replace(holding(tensed), grasp=None))
    assert kinds(decision) == [PhaseKind.OPEN]


def test_release_with_the_shaft_measured_off_the_trocar_moves_the_jaws_alone(verify, tensed):
    held = holding(tensed)
    pushed = held.measurement.position.copy()
    pushed[3] += 0.01
    off = replace(held, measurement=replace(held.measurement, position=pushed))
    assert kinds(verify(request("release"), off)) == [PhaseKind.OPEN]
    assert kinds(verify(request("release"), replace(off, setpoint=pushed))) == [PhaseKind.OPEN]
    eases = [PhaseKind.OPEN, PhaseKind.EASE, PhaseKind.EASE]
    assert kinds(verify(request("release"), held)) == eases


def test_pulling_tissue_nobody_remembers_plans_a_new_pull_from_here(verify, tensed):
    decision = verify(request("pull more"), replace(holding(tensed, s=0.005), grasp=None))
    (phase,) = decision.plan.phases
    np.testing.assert_allclose(phase.path.start, tensed.grasp.pull.evaluate(0.005).q, atol=1e-12)
    assert decision.plan.grasp.pull is phase.path


def test_a_grasp_remembered_elsewhere_is_planned_anew(verify, tensed):
    here = holding(tensed, s=0.01)
    elsewhere = replace(here, grasp=replace(here.grasp, s=0.02))
    decision = verify(request("pull more"), elsewhere)
    assert decision.plan.phases[-1].path is not tensed.grasp.pull


@pytest.mark.parametrize("words", ["hey robot", "stop", "terminate"])
def test_commands_of_the_mode_have_no_phases(verify, joints, words):
    plan = verify(request(words), situation(joints)).plan
    assert plan.command is COMMANDS[words]
    assert plan.phases == ()


def test_plans_are_made_of_the_kinds_of_phases_in_the_row_of_their_command(verify, joints, tensed):
    plans = [tensed, verify(request("withdraw"), situation(joints)).plan]
    plans += [verify(request(w), holding(tensed)).plan for w in ("release", "pull more")]
    for plan in plans:
        assert {phase.kind for phase in plan.phases} <= set(plan.command.phases), plan.command


# Why each command is refused.


@pytest.mark.parametrize("words", ["release", "pull more", "pull less"])
def test_with_nothing_grasped_there_is_nothing_to_pull_or_release(verify, joints, words):
    assert_refused(verify(request(words), situation(joints)), Reason.NOTHING_GRASPED, words)


def test_tissue_already_held_is_not_grasped_again(verify, tensed):
    assert_refused(verify(request("tense"), holding(tensed)), Reason.ALREADY_GRASPED, "1.00 N")


@pytest.mark.parametrize(
    ("words", "now", "after"), [("pull more", 1.9, "2.15 N"), ("pull less", 0.2, "-0.05 N")]
)
def test_a_step_beyond_the_band_is_refused_with_the_band(verify, tensed, words, now, after):
    decision = verify(request(words), holding(tensed, tension=now, target=now))
    assert_refused(decision, Reason.TENSION_LIMIT, after, "allowed 0.10 to 2.00 N")


@pytest.mark.parametrize(
    ("words", "target", "steps", "limit"), [("pull more", 1.0, 10, 2.0), ("pull less", 0.3, 2, 0.1)]
)
def test_steps_that_end_at_a_limit_are_taken_to_it(verify, tensed, words, target, steps, limit):
    """The sums of these steps are 2.000000000000001 and 0.09999999999999998 N."""
    for _ in range(steps):
        here = holding(tensed, tension=target, target=target)
        decision = verify(request(words, tension=0.1), here)
        assert isinstance(decision, Accepted), decision.words
        target = decision.plan.phases[0].tension
    assert target == decision.plan.grasp.tension == limit
    beyond = verify(request(words, tension=0.1), holding(tensed, tension=target, target=target))
    assert_refused(beyond, Reason.TENSION_LIMIT, "allowed 0.10 to 2.00 N")


def test_a_target_that_rounding_alone_puts_beyond_a_limit_is_the_limit(verify, joints):
    decision = verify(request("tense", tension=2.0 + 1e-12), situation(joints))
    assert decision.plan.phases[-1].tension == decision.plan.grasp.tension == 2.0


@pytest.mark.parametrize(
    ("target", "words"),
    [
        (0.05, "would be 0.05 N, allowed 0.10 to 2.00 N"),
        (2.2, "would be 2.20 N, allowed 0.10 to 2.00 N"),
        (9.0, "would be 9.00 N, allowed 0.10 to 2.00 N"),
        (2.004, "would be 2.004 N, allowed 0.100 to 2.000 N"),
        (0.0996, "would be 0.0996 N, allowed 0.1000 to 2.0000 N"),
        (2.00000001, "would be 2.00000001 N, allowed 0.10000000 to 2.00000000 N"),
    ],
)
def test_a_target_outside_the_band_is_refused_and_never_printed_as_its_limit(
    verify, joints, target, words
):
    decision = verify(request("tense", tension=target), situation(joints))
    assert_refused(decision, Reason.TENSION_LIMIT, words)


def test_nor_is_a_present_tension(verify, joints):
    decision = verify(request("tense"), situation(joints, tension=2.404))
    assert_refused(decision, Reason.TENSION_LIMIT, "is 2.404 N already, allowed 2.400 N")


def test_a_present_tension_over_the_limit_lets_only_less_through(verify, tensed):
    tight = holding(tensed, tension=2.5, target=1.0)
    assert_refused(verify(request("pull more"), tight), Reason.TENSION_LIMIT)
    assert isinstance(verify(request("release"), tight), Accepted)
    assert isinstance(verify(request("pull less", tension=1.0), tight), Accepted)


def test_a_step_by_distance_that_would_pull_too_hard_is_refused(verify, tensed):
    near = holding(tensed, s=0.01, tension=1.8)
    decision = verify(request("pull more", distance=0.004), near)
    assert_refused(decision, Reason.TENSION_LIMIT, "2.52 N")


def test_beyond_the_pull_path_there_is_no_more(verify, tensed):
    end = holding(tensed, s=0.03, tension=0.4, target=1.0)
    assert_refused(verify(request("pull more"), end), Reason.DISPLACEMENT_LIMIT, "0 to 30.0 mm")
    far = holding(tensed, s=0.028, tension=0.4)
    decision = verify(request("pull more", distance=0.005), far)
    assert_refused(decision, Reason.DISPLACEMENT_LIMIT, "33.0 mm")
    decision = verify(request("pull less", distance=0.02), holding(tensed, s=0.01))
    assert_refused(decision, Reason.DISPLACEMENT_LIMIT, "-10.0 mm")


def test_with_no_way_back_nothing_is_eased(verify, tensed):
    anew = replace(holding(tensed, s=0.008), grasp=None)
    for step in ({}, {"tension": 0.1}, {"distance": 0.001}):
        decision = verify(request("pull less", **step), anew)
        assert_refused(decision, Reason.DISPLACEMENT_LIMIT, "pulled -", "allowed 0 to 30.0 mm")
    stiff = holding(tensed, s=1e-4)
    assert isinstance(verify(request("pull less"), stiff), Accepted)
    moving = holding(tensed, s=0.0, is_moving=True)
    assert isinstance(verify(request("pull less"), moving), Accepted)


def test_a_longer_pull_than_the_path_is_refused(verify, joints):
    decision = verify(request("tense", distance=0.05), situation(joints))
    assert_refused(decision, Reason.DISPLACEMENT_LIMIT, "50.0 mm", "30.0 mm")


@pytest.mark.parametrize(
    ("part", "changes", "reason", "words"),
    [
        ("scene", {"grasp_point": (1.5, 0.0, 0.3)}, Reason.WORKSPACE, "allowed 60.0 mm"),
        (
            "scene",
            {
                "grasp_point": (0.85, -0.024, 0.279),
                "workspace_centre": (0.6, -0.024, 0.29),
                "workspace_radius": 0.3,
            },
            Reason.UNREACHABLE,
            "mm of a way of",
        ),
        ("rcm", {"insertion": (0.2, 0.25)}, Reason.INSERTION_DEPTH, "allowed 200.0 to 250.0 mm"),
        ("rcm", STRICT, Reason.RCM_TOLERANCE, "um off the trocar, allowed"),
    ],
)
def test_a_scene_that_makes_tense_impossible_gives_its_own_reason(
    planner, joints, part, changes, reason, words
):
    if changes is STRICT:
        changes = {**STRICT, "solver": replace(planner.config.rcm.solver, tolerance=1e-12)}
    verify = Verifier(planner_with(planner, **{part: changes}))
    assert_refused(verify(request("tense"), situation(joints)), reason, words)


def test_joint_limits_in_the_way_are_the_reason_given(planner, joints, home):
    limits, narrow = planner.config.limits, [1, 3]
    upper, lower = np.array(limits.arm_upper), np.array(limits.arm_lower)
    upper[narrow], lower[narrow] = home[narrow] + 0.0201, home[narrow] - 0.0201
    limits = {"arm_lower": tuple(lower), "arm_upper": tuple(upper)}
    verify = Verifier(planner_with(planner, limits=limits))
    decision = verify(request("tense"), situation(joints))
    assert_refused(decision, Reason.JOINT_LIMIT, "joint_", "rad, allowed")
