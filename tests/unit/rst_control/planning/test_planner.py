# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.errors import (
    Infeasible,
    InsertionOutOfRange,
    JointLimitExceeded,
    OutsideWorkspace,
    TrocarDrift,
)
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rcm import rcm_state
from rst_control.tissue.grasp_candidates import grasp_candidates
from tests.support.changed_settings import planner_with


def tip(planner, q):
    return Configuration(planner.model, q).tip


@pytest.fixture
def at_grasp(planner, home):
    return planner.reach(home)[-1].end


def test_the_way_to_the_grasp_ends_at_its_point_with_the_jaws_along_the_approach(planner, at_grasp):
    T, scene = Configuration(planner.model, at_grasp).T_base_tip, planner.config.scene
    np.testing.assert_allclose(T[:3, 3], scene.grasp_point, atol=1e-9)
    np.testing.assert_allclose(-T[:3, 1], scene.approach_axis, atol=1e-9)
    np.testing.assert_allclose(T[:3, 2], scene.jaw_axis, atol=1e-9)


def test_legs_join_exactly_and_begin_where_the_robot_is(planner, home):
    first, second = planner.reach(home)
    np.testing.assert_array_equal(first.start, home)
    np.testing.assert_array_equal(second.start, first.end)


def test_the_last_leg_comes_straight_along_the_approach(planner, home):
    _, last = planner.reach(home)
    scene = planner.config.scene
    assert last.length == pytest.approx(scene.clearance)
    way = tip(planner, last.end) - tip(planner, last.start)
    np.testing.assert_allclose(way / scene.clearance, scene.approach_axis, atol=1e-6)


def test_at_the_grasp_there_is_no_way_left_to_go(planner, at_grasp, home):
    assert len(planner.reach(planner.reach(home)[0].end)) == 1
    _, back = planner.reach(at_grasp)
    assert tip(planner, back.end) == pytest.approx(planner.config.scene.grasp_point)


def test_the_pull_goes_the_whole_allowed_displacement_in_its_direction(planner, at_grasp):
    pull, scene = planner.pull(at_grasp), planner.config.scene
    assert pull.length == pytest.approx(scene.max_displacement)
    way = tip(planner, pull.end) - tip(planner, pull.start)
    direction = np.array(scene.pull_direction) / np.linalg.norm(scene.pull_direction)
    np.testing.assert_allclose(way, scene.max_displacement * direction, atol=1e-9)


def test_the_retreat_goes_back_against_the_approach(planner, at_grasp):
    retreat, scene = planner.retreat(at_grasp), planner.config.scene
    way = tip(planner, retreat.end) - tip(planner, retreat.start)
    np.testing.assert_allclose(way, -np.array(scene.approach_axis) * scene.clearance, atol=1e-9)


def test_reaching_again_and_again_ends_in_the_same_joints(planner, home, at_grasp):
    q = home
    for _ in range(5):
        q = planner.reach(q)[-1].end
        np.testing.assert_allclose(q, at_grasp, atol=1e-6)
        q = planner.retreat(planner.pull(q).end).end


@pytest.fixture
def off(home):
    """Slightly off the trocar."""
    return home + 5e-4 * np.eye(9)[3]


def test_a_shaft_slightly_off_the_trocar_is_put_back_first(planner, off):
    seat, *rest = planner.reach(off)
    np.testing.assert_array_equal(seat.start, off)
    assert rcm_state(Configuration(planner.model, seat.end), planner.trocar).error < 1e-9
    errors = seat.sample(planner.model.chain, planner.trocar).rcm_error
    assert (np.diff(errors) <= 1e-12).all()
    assert len(rest) == 2


@pytest.mark.parametrize(
    ("share", "words"),
    [(0.1, r"um off the trocar, allowed 1\.00 um"), (-1.0, "um off the trocar, allowed")],
    ids=["ends outside the trocar", "leads further off"],
)
def test_a_way_back_that_does_not_lead_into_the_trocar_is_refused(
    planner, home, off, monkeypatch, share, words
):
    monkeypatch.setattr(planner, "project", lambda q: q + share * (home - off))
    with pytest.raises(TrocarDrift, match=words):
        planner.seat(off)


def test_a_shaft_far_off_the_trocar_is_refused(planner, home):
    off = home + 0.05 * np.eye(9)[3]
    with pytest.raises(TrocarDrift, match=r"um off the trocar, allowed 1000\.00 um"):
        planner.reach(off)


def test_a_goal_outside_the_workspace_is_refused_with_both_numbers(planner, home):
    narrow = planner_with(planner, scene={"workspace_radius": 0.012})
    with pytest.raises(OutsideWorkspace, match=r"mm from the workspace centre, allowed 12\.0 mm"):
        narrow.reach(home)


def test_too_little_shaft_in_the_trocar_is_refused(planner, home):
    deep = planner_with(planner, rcm={"insertion": (0.13, 0.25)})
    with pytest.raises(InsertionOutOfRange, match=r"allowed 130\.0 to 250\.0 mm"):
        deep.reach(home)


def test_a_goal_beyond_reach_is_refused(planner, home):
    goal = planner.grasp_candidates[0].T_base_tip.copy()
    goal[:3, 3] = [1.6, 0.0, 0.3]
    with pytest.raises(Infeasible):
        planner.leg(home, goal)


@pytest.fixture
def aside(planner):
    goal = planner.grasp_candidates[0].T_base_tip.copy()
    goal[:3, 3] += [0.02, 0.03, -0.02]
    return goal


def test_a_path_that_strays_between_knots_gets_more_of_them(planner, home, aside):
    usual = planner.leg(home, aside)
    strayed = usual.sample(planner.model.chain, planner.trocar).rcm_error.max()
    strict = planner_with(planner, rcm={"planned_tolerance": 0.5 * strayed})
    finer = strict.leg(home, aside)
    assert len(finer.knots) > 3 * len(usual.knots)
    assert finer.sample(planner.model.chain, planner.trocar).rcm_error.max() < 0.5 * strayed


def test_a_path_that_leaves_the_trocar_even_so_is_refused(planner, home, aside):
    solver = replace(planner.config.rcm.solver, tolerance=1e-12)
    strict = planner_with(planner, rcm={"planned_tolerance": 1e-12, "solver": solver})
    with pytest.raises(TrocarDrift, match="um off the trocar"):
        strict.leg(home, aside)


def test_the_jaws_may_be_changed_about_where_that_is_the_shorter_way(planner, home):
    jaw_axis = tuple(-np.array(planner.config.scene.jaw_axis))
    away = planner_with(planner, scene={"jaw_axis": jaw_axis})
    ways, others = planner.reach(home), away.reach(home)
    np.testing.assert_allclose(others[-1].end, ways[-1].end, atol=1e-9)


def test_a_joint_that_would_enter_its_margin_is_named_with_its_value_and_range(planner, home):
    """The elbow's angle follows from where the wrist is: no swing spares it."""
    config, elbow = planner.config, 3
    (_, last) = planner.reach(home)
    most = float(last.knots[:, elbow].max())
    upper = list(config.limits.arm_upper)
    upper[elbow] = most - 0.005 + config.limits.position_margin  # inside the hard limit all the way
    with pytest.raises(JointLimitExceeded) as caught:
        planner_with(planner, limits={"arm_upper": tuple(upper)}).reach(home)
    error = caught.value
    assert error.joint == "joint_4"
    assert error.upper == pytest.approx(most - 0.005)
    assert error.lower == config.limits.arm_lower[elbow] + config.limits.position_margin
    assert error.upper < error.value < most + 0.01 < upper[elbow]
    assert (
        str(error) == f"joint_4 at {error.value:.3f} rad, allowed -2.550 to {most - 0.005:.3f} rad"
    )


def test_soft_limits_of_the_driver_slow_the_path(planner, home):
    soft = planner_with(planner, limits={"layer": "driver_soft"})
    path = planner.reach(home)[1]
    assert soft.pace(path, 0.02).moving.acceleration < planner.pace(path, 0.02).moving.acceleration


def test_the_grasp_pose_is_a_right_handed_turn_even_from_skew_axes(planner):
    scene = replace(planner.config.scene, approach_axis=(0.1, 0.2, -1.0), jaw_axis=(1.0, 0.3, 0.2))
    R = grasp_candidates(scene)[0].T_base_tip[:3, :3]
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)


def test_warming_up_plans_once_and_changes_nothing(planner, home):
    planner.warm_up()
    first = planner.reach(home)[0]
    planner.warm_up()
    np.testing.assert_array_equal(first.knots, planner.reach(home)[0].knots)


@pytest.mark.parametrize(
    ("allowed", "words"), [(1e-3, "1000.00"), (1e-6, "1.00"), (1e-10, "0.000100")]
)
def test_what_the_shaft_may_stray_is_named_whatever_its_size(allowed, words):
    assert str(TrocarDrift(2e-3, allowed)).endswith(
        f"2000.00 um off the trocar, allowed {words} um"
    )
