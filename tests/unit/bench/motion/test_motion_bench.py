# SPDX-License-Identifier: BSD-3-Clause
"""The bench measures what it says: its judges find faults that are put in, and its parts run."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("PyKDL")

from bench.common.ideal_robot import LightRobot
from bench.common.rig import Rig, random_poses
from bench.motion import inverse, paths, tension, triangulate
from bench.motion.gate.cases import Cases
from bench.motion.gate.near_cases import with_clearance, with_manipulability
from bench.motion.gate.oracle import GateJudge
from rst_control.commands.request import Accepted
from rst_control.config import load_motion_config, load_simulation_config
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.kinematics.rotations import turned
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.types import Reason, Rejected

MOTION, SIMULATION = load_motion_config(), load_simulation_config()
MODEL = load_robot()


@pytest.fixture(scope="module")
def judge():
    return GateJudge()


@pytest.fixture(scope="module")
def cases():
    return Cases(MOTION, seed=1)


def accepted(cases):
    case = cases.feasible()
    while case.request.words != "tense":
        case = cases.feasible()
    decision = case.decide()
    assert isinstance(decision, Accepted)
    return case, decision.plan


def with_scene(case, **changes):
    return replace(case, config=replace(case.config, scene=replace(case.config.scene, **changes)))


def test_the_judge_has_nothing_against_an_accepted_plan(cases, judge):
    case, plan = accepted(cases)
    assert judge.objection(case, plan) == ""
    assert judge._can_follow(case)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda c: with_scene(c, trocar=tuple(np.add(c.config.scene.trocar, 2e-6))), "trocar"),
        (lambda c: with_scene(c, workspace_radius=0.01), "workspace"),
        (
            lambda c: replace(
                c, config=replace(c.config, rcm=replace(c.config.rcm, insertion=(0.2, 0.25)))
            ),
            "insertion",
        ),
        (lambda c: replace(c, config=with_clearance(c.config, 0.3)), "collision"),
        (lambda c: replace(c, config=with_manipulability(c.config, 1e-5)), "near singular"),
    ],
)
def test_the_judge_finds_each_fault_in_a_plan(cases, judge, spoil, words):
    case, plan = accepted(cases)
    assert words in judge.objection(spoil(case), plan)


def test_the_judge_finds_a_plan_that_is_too_fast(cases, judge):
    case, plan = accepted(cases)
    hasty = tuple(replace(phase, acceleration=50.0) for phase in plan.phases)
    assert "acceleration" in judge.objection(case, replace(plan, phases=hasty))


def test_the_judge_checks_all_of_a_way_back(cases, judge):
    case, plan = accepted(cases)
    pull = plan.phases[-1]
    back = replace(pull, start=pull.target, target=pull.start)
    first, last = (pull.path.evaluate(s).q for s in (back.start, back.target))
    held = replace(case, situation=replace(case.situation, setpoint=robot_joints(first, 0.0)))
    begin, end = (Configuration(MODEL, q).tip for q in (first, last))
    centre, radius = tuple(end), 0.5 * float(np.linalg.norm(begin - end))
    narrow = with_scene(held, workspace_centre=centre, workspace_radius=radius)
    assert judge.objection(held, replace(plan, phases=(back,))) == ""
    assert judge.objection(narrow, replace(plan, phases=(back,))).startswith("pull: workspace")


def test_no_reason_is_true_of_a_feasible_command(cases, judge):
    case, _ = accepted(cases)
    for reason in (
        Reason.WORKSPACE,
        Reason.INSERTION_DEPTH,
        Reason.UNREACHABLE,
        Reason.COLLISION,
        Reason.SINGULAR,
    ):
        assert not judge.is_true(case, reason)


def test_feasible_cases_are_accepted_with_plans_that_the_judge_has_nothing_against(cases, judge):
    asked = Counter()
    for _ in range(24):
        case = cases.feasible()
        decision = case.decide()
        assert isinstance(decision, Accepted)
        assert judge.objection(case, decision.plan) == ""
        asked[case.request.words] += 1
    assert set(asked) == {"tense", "pull more", "pull less", "release"}


def test_infeasible_cases_are_refused_for_what_is_wrong_with_them(cases):
    for _ in range(60):
        case = cases.infeasible()
        decision = case.decide()
        assert isinstance(decision, Rejected)
        assert decision.reason is case.expected


def test_near_the_arm_or_a_singularity_some_commands_are_refused_and_all_with_true_reasons(
    cases, judge
):
    reasons = Counter()
    for _ in range(40):
        case = cases.near()
        decision = case.decide()
        if isinstance(decision, Rejected):
            reasons[decision.reason] += 1
            assert judge.is_true(case, decision.reason), decision.words
        else:
            reasons["accepted"] += 1
            assert judge.objection(case, decision.plan) == ""
        if min(reasons[kind] for kind in ("accepted", Reason.COLLISION, Reason.SINGULAR)) == 3:
            return
    pytest.fail(f"too few of a kind: {reasons}")


def test_few_random_paths_and_targets_give_every_figure():
    figures = [*paths.measure(MOTION, 2), *inverse.measure(MOTION, 20)]
    assert all(np.isfinite(figure.value) for figure in figures)
    by_name = {figure.name: figure for figure in figures}
    assert by_name["planned RCM error max by KDL"].is_met


def test_random_poses_are_proper_turns_within_the_workspace():
    for T in random_poses(MOTION, 20, seed=3):
        np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
        away = np.linalg.norm(T[:3, 3] - MOTION.scene.workspace_centre)
        assert away <= MOTION.scene.workspace_radius
    np.testing.assert_allclose(
        turned(np.array([0, 0, np.pi / 2])) @ [1, 0, 0], [0, 1, 0], atol=1e-12
    )


def test_the_light_robot_pulls_the_tissue_as_pybullet_does():
    held = []
    for is_light in (True, False):
        with Rig(MOTION, SIMULATION, is_light=is_light) as rig:
            assert isinstance(rig.robot, LightRobot if is_light else PybulletRobot)
            rig.wake()
            held.append(tension._pull(rig, "tense", 0.5, 0.0))
    light, heavy = held
    assert light.held == pytest.approx(heavy.held, abs=2e-3)
    assert light.settle == pytest.approx(heavy.settle, abs=0.02)


def test_a_random_tissue_is_triangulated_and_one_pulled_too_little_is_not(monkeypatch):
    assert triangulate.attempt(MOTION, 1).faults == ()
    monkeypatch.setattr(triangulate, "TENSION", 0.2)
    faults = triangulate.attempt(MOTION, 1).faults
    assert any("N, at least 0.3" in words for words in faults)
