# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.commands.request import Accepted
from rst_control.commands.verifier import Verifier
from rst_control.config.collision import BodyConfig
from rst_control.errors import Collision, RobotModelError
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.kinematics.robot_model import parse_robot
from rst_control.planning.collision import CollisionModel, Plane
from rst_control.planning.planner import Planner
from rst_control.trajectory.path import Path
from rst_control.types import Reason, Rejected
from tests.support.changed_settings import changed
from tests.unit.rst_control.support.renamed_links import renamed_shapes, renamed_urdf
from tests.unit.rst_control.support.situations import request, situation

# Postures with the shaft near the arm, found by drawing; grasping a little further on brings it
# nearer.
BESIDE_THE_UPPER_ARM = [0.621, -0.803, 1.622, 1.907, -0.051, 1.763, 0.831, 0.553, -0.571]
BESIDE_THE_SHOULDER = [0.755, 1.239, 0.344, -2.146, 0.008, -1.62, 1.039, -0.172, 0.497]


@pytest.fixture
def model(motion_config, robot):
    return CollisionModel(motion_config.collision, robot)


def crowded(config, robot, q, depth=0.16):
    """Settings for a robot that works at q: a trocar round its shaft, tissue before its jaws."""
    frames = Configuration(robot, q).frames
    along, T = frames[forward.SHAFT, :, 2], frames[forward.TIP]
    scene = replace(
        config.scene,
        trocar=tuple(frames[forward.SHAFT, :, 3] + depth * along),
        home=tuple(q),
        workspace_centre=tuple(T[:, 3]),
        grasp_point=tuple(T[:, 3] - config.scene.clearance * T[:, 1]),
        approach_axis=tuple(-T[:, 1]),
        jaw_axis=tuple(T[:, 2]),
        pull_direction=tuple(-along),
    )
    return replace(config, scene=scene)


def tense(config, robot, q):
    here = situation(robot_joints(np.array(q), 0.0))
    return Verifier(Planner(robot, config))(request("tense"), here)


@pytest.mark.parametrize(
    ("q", "arm"), [(BESIDE_THE_UPPER_ARM, "upper arm"), (BESIDE_THE_SHOULDER, "shoulder")]
)
def test_a_way_that_brings_the_shaft_near_the_arm_is_refused_with_names_and_numbers(
    motion_config, robot, model, q, arm
):
    assert model.clearance(np.array(q)).distance > motion_config.collision.clearance  # at the start
    config = crowded(motion_config, robot, q)
    with pytest.raises(Collision) as caught:
        Planner(robot, config).reach(np.array(q))
    error = caught.value
    assert {error.first, error.second} == {"shaft", arm}
    assert 0.010 < error.distance < error.allowed == 0.015
    decision = tense(config, robot, q)
    assert isinstance(decision, Rejected)
    assert decision.reason is Reason.COLLISION
    for words in ("shaft", arm, f"{error.distance * 1e3:.1f} mm", "allowed 15.0 mm"):
        assert words in decision.words


@pytest.mark.parametrize("q", [BESIDE_THE_UPPER_ARM, BESIDE_THE_SHOULDER])
def test_the_same_way_is_accepted_where_less_distance_will_do(motion_config, robot, q):
    config = changed(crowded(motion_config, robot, q), collision={"clearance": 0.001})
    assert isinstance(tense(config, robot, q), Accepted)


def test_a_robot_that_stands_too_near_already_plans_nothing_but_opening_the_jaws(
    motion_config, robot, model
):
    q = np.array(BESIDE_THE_UPPER_ARM)
    need = {"clearance": model.clearance(q).distance + 0.001}
    config = changed(crowded(motion_config, robot, q), collision=need)
    verify = Verifier(Planner(robot, config))
    joints = robot_joints(q, 0.0)
    held = situation(joints, gripped=True, tension=1.0)
    for words in ("pull more", "pull less"):
        assert verify(request(words), held).reason is Reason.COLLISION
    (opening,) = verify(request("release"), held).plan.phases
    assert opening.path is None


def test_usual_work_keeps_far_from_everything(planner, model, home):
    reach, last = planner.reach(home)
    for path in (reach, last, planner.pull(last.end), planner.retreat(last.end)):
        for knot in path.knots:
            assert model.clearance(knot).distance > 0.15


@pytest.mark.parametrize("seed", range(8))
def test_a_session_through_another_trocar_is_not_refused(planner, home, seed):
    """The whole scene, trocar included, some centimetres elsewhere."""
    rng, scene = np.random.default_rng(seed), planner.config.scene
    shift = rng.uniform(-0.03, 0.03, 3)
    moved = {
        name: tuple(np.array(getattr(scene, name)) + shift)
        for name in ("trocar", "workspace_centre", "grasp_point")
    }
    T = Configuration(planner.model, home).T_base_tip
    T[:3, 3] += shift
    elsewhere = np.array(moved["trocar"])
    q = planner.solver.search(T, elsewhere).q
    scene = replace(scene, home=tuple(q), **moved)
    other = Planner(planner.model, replace(planner.config, scene=scene))
    last = other.reach(q)[-1]
    assert other.pull(last.end).length == pytest.approx(scene.max_displacement)
    other.retreat(last.end)


@pytest.mark.parametrize(
    ("table", "away"),
    [
        ({"table_height": 0.25}, {"has_table": False}),
        # behind x = 0.45 m
        ({"table_normal": (-2.0, 0.0, 0.0), "table_height": -0.45}, {"table_height": -1.0}),
    ],
    ids=["too high under the arm", "of an arm on a wall"],
)
def test_a_table_in_the_way_is_named_and_can_be_taken_away(motion_config, robot, home, table, away):
    near = changed(motion_config, collision=table)
    decision = tense(near, robot, home)
    assert decision.reason is Reason.COLLISION
    assert "mm from table, allowed 15.0 mm" in decision.words
    assert isinstance(tense(changed(near, collision=away), robot, home), Accepted)


def test_a_shoulder_of_any_name_may_touch_the_table(motion_config, robot, home, model):
    shapes = renamed_shapes(motion_config.collision)
    renamed = CollisionModel(shapes, parse_robot(renamed_urdf()))
    assert renamed.clearance(home) == model.clearance(home)
    high = replace(motion_config.collision, table_height=0.25)
    raised = CollisionModel(replace(shapes, table_height=0.25), parse_robot(renamed_urdf()))
    assert raised.clearance(home) == CollisionModel(high, robot).clearance(home)
    assert raised.clearance(home).first != "shoulder"


def test_the_height_over_a_tilted_plane_is_that_of_the_lowest_point(motion_config, robot, home):
    config = replace(motion_config.collision, has_table=False)
    normal = np.array([0.6, 0.0, 0.8])
    arm = tuple(body.link for body in config.bodies if body.link != "finger_left_link")
    plane = Plane("patient", (0.6, 0.0, 0.8), 0.4, 0.3, exempt=arm)
    found = CollisionModel(config, robot, (plane,)).clearance(home)
    assert (found.first, found.second, found.allowed) == ("jaws", "patient", 0.3)
    (jaws,) = [body for body in config.bodies if body.link == "finger_left_link"]
    frame = Configuration(robot, home).frames[8]
    ends = [frame[:, 3] + frame[:, :3] @ point for point in (jaws.start, jaws.end)]
    lowest = min(float(normal @ end) for end in ends)
    assert found.distance == pytest.approx(lowest - 0.4 - jaws.radius)


def test_what_is_named_is_what_is_furthest_below_its_own_limit(motion_config, robot, home):
    exempt = ("base_link", "shoulder_link", "half_arm_1_link")
    floor = Plane("floor", (0.0, 0.0, 1.0), -0.5, 0.9, exempt)  # far away, but more is asked for
    found = CollisionModel(motion_config.collision, robot, (floor,)).clearance(home)
    assert found.second == "floor"
    assert 0.5 < found.distance < 0.9


def test_the_worst_place_of_a_path_is_reported_not_the_first(motion_config, robot, model, planner):
    q = np.array(BESIDE_THE_UPPER_ARM)
    away, into = q.copy(), q.copy()
    into[5] += 0.25
    path = Path(np.array([away, into]), np.tile(into - away, (2, 1)), 1.0)
    places = [model.clearance(path.evaluate(s).q).distance for s in np.linspace(0.0, 1.0, 11)]
    assert min(places) < 0.01
    with pytest.raises(Collision) as caught:
        model.check(path.sample(robot.chain, planner.trocar))
    assert caught.value.distance == pytest.approx(min(places), abs=1e-9)


@pytest.mark.parametrize("field", ["bodies", "left_out"])
def test_a_link_that_the_robot_does_not_have_is_refused_by_name(motion_config, robot, field):
    config = motion_config.collision
    if field == "bodies":
        body = BodyConfig(name="x", link="elbow_link", start=(0,) * 3, end=(0,) * 3, radius=0.1)
        wrong = replace(config, bodies=(*config.bodies, body))
    else:
        wrong = replace(config, left_out=(replace(config.left_out[0], others=("elbow_link",)),))
    with pytest.raises(RobotModelError, match="'elbow_link', allowed: base_link, shoulder_link"):
        CollisionModel(wrong, robot)


def test_joints_that_are_no_numbers_are_refused(model, planner, robot, home):
    samples = planner.reach(home)[0].sample(robot.chain, planner.trocar)
    for place in (0, 57, -1):
        q = samples.q.copy()
        q[place, :, 4] = np.nan
        with pytest.raises(Collision):
            model.check(replace(samples, q=q))


def test_one_body_at_no_place_counts_though_others_are_clear_of_all_planes(
    motion_config, robot, home
):
    bodies = {body.link: body for body in motion_config.collision.bodies}
    two = (bodies["finger_left_link"], bodies["half_arm_1_link"])
    apart = replace(motion_config.collision.left_out[0], link=two[0].link, others=(two[1].link,))
    config = replace(motion_config.collision, bodies=two, left_out=(apart,))
    q = np.where(np.arange(9) == 6, np.nan, home)
    assert np.isnan(CollisionModel(config, robot).clearance(q).distance)
