# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from bench.common.rig import random_poses
from rst_control.commands.request import Accepted
from rst_control.config import URDF_FILE
from rst_control.errors import Infeasible, InsertionOutOfRange, TrocarDrift, Unreachable
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.kinematics.robot_model import parse_robot
from rst_control.planning.insertion import Insertion, ToolBent
from rst_control.planning.plan import PhaseKind
from rst_control.planning.planner import Planner
from rst_control.types import Reason
from tests.support.changed_settings import changed, planner_with
from tests.unit.rst_control.support.situations import request, situation
from typed_config import ConfigError

ALIGN, INSERT, WITHDRAW = PhaseKind.ALIGN, PhaseKind.INSERT, PhaseKind.WITHDRAW


@pytest.fixture(scope="module")
def insertion(planner):
    return Insertion(planner)


@pytest.fixture(scope="module")
def out(insertion, home):
    return insertion.withdraw(home)


def kinds(legs):
    return [leg.kind for leg in legs]


def place(planner, q):
    return planner.patient.trocar_pose(q)


def on_the_way(out, share):
    """Straight tool, part-way between working pose and outside."""
    return out[-1].path.evaluate(share * out[-1].path.length).q


def ends_meet(legs, q):
    for leg in legs:
        np.testing.assert_allclose(leg.path.start, q, atol=1e-12)
        q = leg.path.end
    return q


# Ways.


def test_a_withdrawal_straightens_the_tool_then_goes_straight_out(planner, home, out):
    assert kinds(out) == [ALIGN, WITHDRAW]
    gate = ends_meet(out, home)
    np.testing.assert_allclose(gate[7:], 0.0, atol=1e-12)
    end = place(planner, gate)
    assert end.is_outside
    assert end.insertion == pytest.approx(-planner.config.scene.standoff, abs=1e-9)


def test_the_arm_rests_while_the_tool_straightens_on_the_spot(home, out):
    knots = out[0].path.knots
    np.testing.assert_array_equal(knots[:, :7], np.tile(home[:7], (len(knots), 1)))


def test_on_the_way_out_the_shaft_slides_along_itself(planner, out):
    path = out[-1].path
    shafts = [
        Configuration(planner.model, path.evaluate(s).q).T_base_shaft
        for s in np.linspace(0.0, path.length, 300)
    ]
    for T in shafts:
        np.testing.assert_allclose(T[:3, 2], shafts[0][:3, 2], atol=1e-6)
    samples = path.sample(planner.model.chain, planner.trocar)
    assert samples.rcm_error.max() < planner.config.rcm.planned_tolerance
    steps = np.diff([T[:3, 3] for T in shafts], axis=0) @ shafts[0][:3, 2]
    assert (steps < 0.0).all()


def test_an_insertion_from_the_gate_is_the_way_out_backwards(planner, home, insertion, gate, out):
    legs = insertion.insert(gate)
    assert kinds(legs) == [INSERT, INSERT]
    np.testing.assert_allclose(ends_meet(legs, gate), home, atol=1e-12)
    np.testing.assert_allclose(legs[0].path.knots, out[-1].path.knots[::-1])


def test_from_elsewhere_an_approach_comes_first(planner, home, insertion, gate):
    away = gate + 0.4 * np.eye(9)[0]
    legs = insertion.insert(away)
    assert kinds(legs) == [PhaseKind.APPROACH, INSERT, INSERT]
    np.testing.assert_allclose(ends_meet(legs, away), home, atol=1e-12)


@pytest.mark.parametrize("share", [0.35, 0.5, 0.65, 0.8, 0.9])
def test_part_way_in_both_commands_go_on_from_there(planner, home, insertion, out, share):
    q = on_the_way(out, share)
    assert not place(planner, q).is_outside
    further = insertion.insert(q)
    assert set(kinds(further)) == {INSERT}
    np.testing.assert_allclose(
        Configuration(planner.model, ends_meet(further, q)).T_base_tip,
        Configuration(planner.model, home).T_base_tip,
        atol=1e-7,
    )
    back = insertion.withdraw(q)
    assert kinds(back) == [WITHDRAW]
    assert place(planner, ends_meet(back, q)).is_outside
    for leg in (*further, *back):
        samples = leg.path.sample(planner.model.chain, planner.trocar)
        assert samples.rcm_error.max() < planner.config.rcm.planned_tolerance


def test_the_wrist_bends_only_where_it_is_inside_by_the_least_insertion(
    planner, home, insertion, gate, out
):
    least, is_bent = planner.config.rcm.insertion[0], []
    ways = [insertion.insert(gate), insertion.insert(on_the_way(out, 0.9))]
    for leg in (*ways[0], *ways[1], *insertion.withdraw(home)):
        samples = leg.path.sample(planner.model.chain, planner.trocar)
        bent = np.abs(samples.q[:, 0, 7:]).max(axis=1) > 1e-9
        assert (0.28 - samples.along[bent] >= least).all()
        is_bent.append(bent.any())
    assert any(is_bent) and not all(is_bent)


def test_a_tool_bent_part_way_in_is_refused(planner, insertion, out):
    bent = on_the_way(out, 0.7)
    bent[7] = 0.2
    for plan in (insertion.insert, insertion.withdraw):
        with pytest.raises(ToolBent, match=r"bent by 0\.200 rad .* allowed 0\.010 rad below 50"):
            plan(bent)


def test_a_shaft_slightly_off_is_seated_first(planner, insertion, home):
    off = home + 5e-4 * np.eye(9)[3]
    legs = insertion.withdraw(off)
    assert kinds(legs) == [ALIGN, ALIGN, WITHDRAW]
    errors = legs[0].path.sample(planner.model.chain, planner.trocar).rcm_error
    assert errors[0] > 1e-4 and errors[-1] < 1e-9


def test_a_shaft_far_off_the_trocar_is_refused(insertion, home):
    off = home + 0.05 * np.eye(9)[3]
    for plan in (insertion.insert, insertion.withdraw):
        with pytest.raises(TrocarDrift):
            plan(off)


def test_from_every_pose_in_the_workspace_there_is_a_way_out(planner, insertion, home):
    q, count = home, 0
    for pose in random_poses(planner.config, 120, seed=11):
        try:
            q = planner.leg(q, pose).end
        except Infeasible:
            continue
        legs = insertion.withdraw(q)
        assert place(planner, ends_meet(legs, q)).is_outside
        count += 1
    assert count > 20


def test_longer_jaws_keep_the_speed_of_their_tip_where_they_straighten(planner, home):
    short, long = '"0 -0.015 0"', '"0 -0.030 0"'  # from a finger's joint to the tip
    text = URDF_FILE.read_text(encoding="utf-8")
    assert text.count(short) == 1
    longer = Planner(parse_robot(text.replace(short, long)), planner.config)
    most, bent = planner.config.controller.speed.insertion, home.copy()
    bent[7:] = 0.5, 0.0
    for robot, length in ((planner, 0.0265), (longer, 0.0415)):
        path = Insertion(robot)._unbent(bent)
        assert path.length == pytest.approx(0.5 * length)
        ends = [path.evaluate(s).q for s in np.linspace(0.0, path.length, 200)]
        tips = [Configuration(robot.model, q).tip for q in ends]
        way = float(np.linalg.norm(np.diff(tips, axis=0), axis=1).sum())
        pace = robot.pace(path, most).moving.speed
        assert pace * way / path.length <= most * 1.0001


def test_where_the_tip_has_no_room_to_swing_the_tool_straightens_about_it(planner, home):
    straight = home.copy()
    straight[7:] = 0.0
    tip, swung = (Configuration(planner.model, q).tip for q in (home, straight))
    centre = tip - 0.020 * (swung - tip) / np.linalg.norm(swung - tip)
    scene = {"workspace_centre": tuple(centre.tolist()), "workspace_radius": 0.0205}
    upper = np.where(np.arange(7) == 5, 2.6, planner.config.limits.arm_upper)
    config = changed(planner.config, scene=scene, limits={"arm_upper": tuple(upper)})
    wide = URDF_FILE.read_text(encoding="utf-8").replace('upper="2.09"', 'upper="2.6"')
    narrow = Planner(parse_robot(wide), config)
    align, withdraw = Insertion(narrow).withdraw(home)
    tips = align.path.sample(narrow.model.chain, narrow.trocar).tip
    np.testing.assert_allclose(tips, np.tile(tip, (len(tips), 1)), atol=1e-6)
    np.testing.assert_allclose(align.path.end[7:], 0.0, atol=1e-9)
    assert place(narrow, ends_meet((align, withdraw), home)).is_outside


def test_with_another_trocar_the_working_pose_keeps_the_tool_where_home_has_it(planner, home):
    trocar = tuple(np.add(planner.config.scene.trocar, (0.004, -0.003, 0.005)))
    moved = planner_with(planner, scene={"trocar": trocar})
    working = Insertion(moved).working
    assert moved.patient.trocar_pose(working).error < 1e-9
    np.testing.assert_allclose(
        Configuration(planner.model, working).T_base_tip,
        Configuration(planner.model, home).T_base_tip,
        atol=1e-8,
    )


def test_more_shaft_inside_than_allowed_is_refused(planner, home):
    shallow = planner_with(planner, rcm={"insertion": (0.05, 0.09)})
    with pytest.raises(InsertionOutOfRange, match=r"allowed -30\.0 to 90\.0 mm"):
        Insertion(shallow).withdraw(home)


def test_where_all_swings_fail_the_reason_of_the_best_one_is_given(planner, out, monkeypatch):
    insertion, rooms = Insertion(planner), []

    def refuse(path, must_stay):
        rooms.append(insertion._room(path))
        if len(rooms) == 1:
            raise TrocarDrift(0.002, 0.001)  # with knots as usual: denser ones are tried
        raise Infeasible(f"refusal {len(rooms)}")

    monkeypatch.setattr(insertion, "_checked", refuse)
    with pytest.raises(Infeasible, match="refusal 2"):
        insertion._along_shaft(out[-1].path.start, -0.02)
    assert len(rooms) > 3 and rooms[0] > max(rooms[2:])


def test_where_no_swing_reaches_the_end_the_furthest_is_given(planner, out, monkeypatch):
    insertion = Insertion(planner)

    def short(q, way, swing, spacing):
        raise Unreachable(0.01 - 0.001 * abs(swing), abs(way))

    monkeypatch.setattr(insertion, "_continued", short)
    with pytest.raises(Unreachable, match=r"beyond 10\.0 mm of a way of 20\.0 mm"):
        insertion._along_shaft(out[-1].path.start, -0.02)


def test_the_surface_margin_stops_a_withdrawal_that_would_end_too_near(planner, home):
    near = planner_with(planner, scene={"standoff": 0.012})
    with pytest.raises(Infeasible, match=r"jaws -?[0-9.]+ mm from patient's surface"):
        Insertion(near).withdraw(home)


def test_a_standoff_that_leaves_no_margin_however_the_shaft_stands_is_refused_at_start(planner):
    near = planner_with(planner, scene={"standoff": 0.020})
    words = r"scene.standoff is 0.02, allowed: at least 0.0220 m: scene.surface_margin, 0.005 m"
    with pytest.raises(ConfigError, match=words):
        Insertion(near).warm_up()


def test_a_standoff_without_a_margin_where_the_shaft_leans_is_reported_at_start(planner, caplog):
    near = planner_with(planner, scene={"standoff": 0.0221})
    Insertion(near).warm_up()
    assert '"withdraw" and "insert" will be refused at the working pose: jaws' in caplog.text
    assert "scene.standoff is 0.0221 m, scene.surface_margin 0.005 m" in caplog.text
    caplog.clear()
    Insertion(planner).warm_up()
    assert not caplog.records


def test_planning_changes_nothing(insertion, gate):
    first = insertion.insert(gate)
    insertion.warm_up()
    for one, other in zip(first, insertion.insert(gate), strict=True):
        np.testing.assert_array_equal(one.path.knots, other.path.knots)


# Commands.


def asked(verify, words, q, **more):
    return verify(request(words), situation(robot_joints(q, 0.0), **more))


def test_insert_closes_the_jaws_first_and_says_where_it_ends(verify, gate, home):
    decision = asked(verify, "insert", gate)
    assert isinstance(decision, Accepted)
    assert [phase.kind for phase in decision.plan.phases] == [ALIGN, INSERT, INSERT]
    jaws = decision.plan.phases[0]
    assert (jaws.path, jaws.opening) == (None, 0.0)
    assert decision.plan.words == "inserts the tool to 121 mm inside the trocar"
    assert asked(verify, "withdraw", home).plan.words.endswith("30 mm outside the trocar")


def test_each_phase_keeps_its_own_speed(verify, planner, gate):
    away, speed = gate.copy(), planner.config.controller.speed
    away[0] += 0.4
    most = {PhaseKind.APPROACH: speed.approach, INSERT: speed.insertion, WITHDRAW: speed.insertion}
    for phase in asked(verify, "insert", away).plan.phases[1:]:
        assert 0.0 < phase.speed <= most[phase.kind]
    slid = asked(verify, "insert", gate).plan.phases[1]
    assert slid.speed == pytest.approx(speed.insertion)


@pytest.mark.parametrize("words", ["tense", "release", "pull more", "pull less"])
def test_outside_only_insert_moves_the_tool(verify, gate, words):
    decision = asked(verify, words, gate)
    assert decision.reason is Reason.NOT_INSERTED
    assert "tip 30.0 mm outside the trocar" in decision.words and '"insert" first' in decision.words


@pytest.mark.parametrize("words", ["tense", "release", "pull more", "pull less"])
def test_part_way_in_the_depth_is_named(verify, out, words):
    decision = asked(verify, words, on_the_way(out, 0.6))
    assert decision.reason is Reason.INSERTION_DEPTH
    assert "mm of shaft inserted, allowed 50.0 to 250.0 mm" in decision.words


def test_what_is_done_already_is_refused(verify, gate, home):
    inside, outside = asked(verify, "insert", home), asked(verify, "withdraw", gate)
    assert inside.reason is outside.reason is Reason.ALREADY_THERE
    assert "already inserted: 98.2 mm of shaft" in inside.words
    assert "already outside: tip 30.0 mm outside" in outside.words


def test_held_tissue_must_be_released_first(verify, home, gate):
    for words, q in (("withdraw", home), ("insert", gate)):
        decision = asked(verify, words, q, gripped=True)
        assert decision.reason is Reason.ALREADY_GRASPED
        assert "release first" in decision.words


def test_jaws_that_hold_something_open_anywhere(verify, gate, out):
    for q in (gate, on_the_way(out, 0.6)):
        phases = asked(verify, "release", q, gripped=True).plan.phases
        assert phases[0].kind is PhaseKind.OPEN


def test_a_shaft_off_the_trocar_with_the_tool_inside_is_refused_with_the_distance(verify, home):
    off = home + 0.01 * np.eye(9)[3]
    for words in ("insert", "withdraw"):
        decision = asked(verify, words, off)
        assert decision.reason is Reason.RCM_TOLERANCE
        assert "allowed 1000.00 um" in decision.words


def test_a_tool_beside_the_trocar_and_too_near_the_patient_is_refused(verify, planner, gate):
    model, outward = planner.model, planner.patient.outward
    q, margin = gate.copy(), planner.config.scene.surface_margin
    while place(planner, q).height > 0.8 * margin:  # down towards the surface, and aside
        J = Configuration(model, q).J_tip[:3]
        aside = np.cross(outward, [0.0, 1.0, 0.0])
        q += J.T @ np.linalg.solve(J @ J.T + 1e-4 * np.eye(3), -5e-4 * outward + 5e-4 * aside)
    decision = asked(verify, "insert", q)
    assert decision.reason is Reason.COLLISION
    assert "from patient's surface, allowed 5.0 mm and more" in decision.words
