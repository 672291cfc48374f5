# SPDX-License-Identifier: BSD-3-Clause
"""The controller finds by itself how to take a sheet, and says why where it cannot."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rst_control.commands.request import Accepted
from rst_control.commands.tense import choose_grasp
from rst_control.commands.verifier import Verifier, reason_of
from rst_control.errors import NoGrasp, OutsideWorkspace, Unreachable
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rotations import turned
from rst_control.planning.plan import PhaseKind
from rst_control.planning.planner import Planner
from rst_control.tissue.grasp_candidates import LONGEST_PULL, MAX_ASIDE, grasp_candidates
from rst_control.tissue.sheet import free_sides, rest_points, rim_nodes, sheet_normal
from rst_control.tissue.triangulation import pull_direction
from rst_control.types import Reason
from tests.unit.rst_control.support.situations import request, situation
from typed_config import ConfigError

OPEN = {"approach_axis": (), "jaw_axis": (), "pull_direction": ()}


@pytest.fixture(scope="module")
def scene(motion_config):
    return replace(motion_config.scene, **OPEN)


def planner_of(planner, scene, **more):
    return Planner(planner.model, replace(planner.config, scene=scene, **more))


def sheet_turned(scene, vector):
    """The scene with its sheet turned about the grasp point by a rotation vector [rad]."""
    R, grasp = turned(np.array(vector)), np.array(scene.grasp_point)
    tissue = replace(
        scene.tissue,
        along=tuple(R @ scene.tissue.along),
        across=tuple(R @ scene.tissue.across),
        centre=tuple(grasp + R @ (scene.tissue.centre - grasp)),
    )
    return replace(scene, tissue=tissue)


def test_directions_that_the_scene_names_are_kept(motion_config):
    scene = motion_config.scene
    (way,) = grasp_candidates(scene)
    assert_allclose(-way.T_base_tip[:3, 1], scene.approach_axis, atol=1e-12)
    assert_allclose(way.T_base_tip[:3, 2], scene.jaw_axis, atol=1e-12)
    assert_allclose(way.pull, scene.pull_direction / np.linalg.norm(scene.pull_direction))
    assert way.length == scene.max_displacement


@pytest.mark.parametrize("vector", [(0, 0, 0), (0.3, 0, 0), (0, -0.4, 0), (0.2, 0.1, 0.5)])
def test_every_way_has_the_sheet_between_the_jaws_and_the_squarest_comes_first(scene, vector):
    scene = sheet_turned(scene, vector)
    normal, ways = sheet_normal(scene.tissue), grasp_candidates(scene)
    for way in ways:
        R = way.T_base_tip[:3, :3]
        assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) == pytest.approx(1.0)
        assert abs(way.T_base_tip[:3, 1] @ normal) < 1e-9  # within the sheet, from its free side
        ways_in = [-outward for _, outward in free_sides(scene.tissue)]
        assert max(-way.T_base_tip[:3, 1] @ ways_in[0], 0.0) >= np.cos(MAX_ASIDE) - 1e-9
        assert abs(R[:, 0] @ normal) == pytest.approx(np.cos(way.askew), abs=1e-6)
    assert ways[0].askew == pytest.approx(0.0, abs=1e-6)
    askew = [round(way.askew, 6) for way in ways]
    assert askew == sorted(askew)


def test_the_pull_leads_from_between_the_anchors_and_strains_no_more_than_it_may(scene):
    way = grasp_candidates(scene)[0]
    rim = rest_points(scene.tissue)[rim_nodes(scene.tissue)]
    assert_allclose(way.pull, pull_direction(rim, np.array(scene.grasp_point)))
    assert way.length <= min(scene.max_displacement, LONGEST_PULL * scene.tissue.size[0] + 1e-9)


def test_a_chosen_grasp_keeps_the_point_the_way_and_the_retreat(planner, scene, home):
    chooser = planner_of(planner, scene)
    plan = choose_grasp(chooser, home)
    tip = Configuration(planner.model, plan.reach[-1].end).T_base_tip
    assert_allclose(tip[:3, 3], scene.grasp_point, atol=1e-6)
    assert abs(tip[:3, 0] @ sheet_normal(scene.tissue)) == pytest.approx(
        np.cos(plan.candidate.askew)
    )
    pulled = Configuration(planner.model, plan.pull.end).tip - tip[:3, 3]
    assert_allclose(pulled, plan.candidate.length * plan.candidate.pull, atol=1e-6)
    back = Configuration(planner.model, plan.retreat.end).tip - tip[:3, 3]
    assert_allclose(back, scene.clearance * plan.candidate.T_base_tip[:3, 1], atol=1e-6)


def test_the_same_situation_gives_the_same_choice(planner, scene, home):
    first, second = (choose_grasp(planner_of(planner, scene), home) for _ in range(2))
    assert_array_equal(first.candidate.T_base_tip, second.candidate.T_base_tip)
    assert_array_equal(first.pull.knots, second.pull.knots)


def test_where_the_best_way_is_blocked_the_next_is_taken(planner, scene, home, monkeypatch):
    chooser = planner_of(planner, scene)
    best, blocked = choose_grasp(chooser, home), []
    reach = chooser.reach

    def narrow(q, way=None):
        if way is best.candidate:
            blocked.append(way)
            raise OutsideWorkspace(1.0, 0.1)
        return reach(q, way)

    monkeypatch.setattr(chooser, "reach", narrow)
    other = choose_grasp(chooser, home)
    assert blocked
    assert other.candidate is not best.candidate


@pytest.mark.parametrize("free", [1, 0])
def test_the_controller_starts_if_any_way_is_free(planner, scene, monkeypatch, free):
    chooser = planner_of(planner, scene)
    reach = chooser.reach

    def narrow(q, way):
        if free and way is chooser.grasp_candidates[-1]:
            return reach(q, chooser.grasp_candidates[3])
        raise OutsideWorkspace(1.0, 0.1)

    monkeypatch.setattr(chooser, "reach", narrow)
    if free:
        chooser.warm_up()
    else:
        with pytest.raises(OutsideWorkspace):
            chooser.warm_up()


def test_where_no_way_is_free_the_refusal_names_the_reason_of_the_best(
    planner, scene, home, joints
):
    far = replace(scene, workspace_radius=0.012)
    chooser = planner_of(planner, far)
    with pytest.raises(NoGrasp, match=r"of 12 ways .* workspace centre, allowed 12\.0") as caught:
        choose_grasp(chooser, home)
    assert isinstance(caught.value.reasons[0], OutsideWorkspace)
    decision = Verifier(chooser)(request("tense"), situation(joints))
    assert decision.reason is Reason.WORKSPACE
    assert 'cannot "tense": none of' in decision.words


@pytest.mark.parametrize(
    ("last", "reason"),
    [(OutsideWorkspace(9.0, 0.1), Reason.WORKSPACE), (Unreachable(0.0, 1.0), Reason.NO_GRASP)],
)
def test_the_refusal_counts_all_ways_tried_and_names_the_reasons_of_the_best_three(last, reason):
    best = [OutsideWorkspace(float(n), 0.1) for n in range(4)]
    error = NoGrasp((*best, last))
    assert "none of 5 ways" in str(error)
    assert [str(cause) in str(error) for cause in error.reasons] == [True] * 3 + [False] * 2
    assert reason_of(error) is reason


def test_tense_is_planned_without_any_direction_in_the_scene(planner, scene, joints):
    decision = Verifier(planner_of(planner, scene))(request("tense", 0.5), situation(joints))
    assert isinstance(decision, Accepted)
    assert decision.plan.phases[-1].kind is PhaseKind.PULL
    assert decision.plan.phases[-1].tension == 0.5


@pytest.mark.parametrize("value", [(1.0,), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)])
def test_a_direction_that_is_none_is_refused_at_start(motion_config, value):
    with pytest.raises(ConfigError, match="jaw_axis"):
        replace(motion_config.scene, jaw_axis=value)


@pytest.mark.parametrize(("why", "is_refused"), [("", True), ("no zero yet", False)])
def test_a_high_tension_refuses_it_only_where_it_is_trusted(planner, joints, why, is_refused):
    high = planner.config.controller.tension.limit + 0.2
    here = situation(joints, tension=high, tension_invalid_reason=why)
    decision = Verifier(planner)(request("tense"), here)
    assert isinstance(decision, Accepted) is not is_refused, decision
    if is_refused:
        assert decision.reason is Reason.TENSION_LIMIT
