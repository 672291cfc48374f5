# SPDX-License-Identifier: BSD-3-Clause
"""What viewers show of the controller: the way of the plan, the pull, and what is gone."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.visualization.controller_shapes import (
    AMBER,
    ARROW_SCALE,
    GREEN,
    RED,
    ControllerShapes,
)
from rst_control.visualization.shapes import ShapeKind, circle
from rst_control.visualization.tip_route import route
from tests.unit.rst_control.support.executor_rig import Rig, tip_of

ALWAYS = {"workspace", "grasp point", "trocar", "trocar ring", "shaft line"}


@pytest.fixture
def rig():
    return Rig()


def shapes(rig, view=None):
    make = ControllerShapes(load_robot(), rig.config)
    found = make(view or rig.view, rig.config.scene)
    assert len({shape.name for shape in found}) == len(found)
    return {shape.name: shape for shape in found}


def test_before_the_robot_speaks_only_places_are_shown(rig):
    assert set(shapes(rig, ControllerSnapshot.at_start())) == ALWAYS


def test_at_rest_without_tissue_there_is_no_way_and_no_pull(rig):
    rig.awake()
    shown = shapes(rig)
    assert set(shown) == ALWAYS | {"rcm error", "tension words"}
    assert shown["tension words"].text == "0.00 N, active"
    assert shown["rcm error"].text.startswith("RCM 0.0")


def test_while_reaching_the_way_ahead_begins_at_the_tip_and_ends_with_the_pull(rig):
    rig.moving("reach")
    ahead, tip = shapes(rig)["path ahead"].points, tip_of(rig.joints)
    assert np.linalg.norm(ahead[0] - tip) < 5e-5
    pull = rig.view.plan.phases[-1]
    end = tip_of(robot_joints(pull.path.evaluate(pull.target).q, 0.0))
    distance = np.linalg.norm(ahead - np.array(rig.config.scene.grasp_point), axis=1)
    assert distance.min() < 1e-3
    assert np.linalg.norm(ahead[-1] - end) < 5e-5


def test_travelled_and_ahead_meet_at_the_tip_all_the_way(rig):
    rig.awake().say("tense")
    lengths = []
    for _ in range(40):
        rig.run(0.05)
        if not rig.view.is_moving:
            break
        shown = shapes(rig)
        if "path travelled" not in shown or "path ahead" not in shown:
            continue
        travelled, ahead = shown["path travelled"].points, shown["path ahead"].points
        assert np.linalg.norm(travelled[-1] - tip_of(rig.joints)) < 5e-5
        assert np.linalg.norm(travelled[-1] - ahead[0]) < 5e-4
        lengths.append(np.linalg.norm(np.diff(travelled, axis=0), axis=1).sum())
    assert len(lengths) > 5 and np.all(np.diff(lengths) >= 0.0)


def test_the_arrow_is_the_measured_force_and_the_words_say_where_it_goes(rig):
    rig.awake().finish("tense")
    shown = shapes(rig)
    tail, head = shown["tension"].points
    force = rig.view.measurement.force
    assert shown["tension"].kind is ShapeKind.ARROW
    np.testing.assert_allclose(head - tail, ARROW_SCALE * force, atol=1e-12)
    assert shown["tension words"].text == f"{rig.view.tension:.2f} N -> 1.00 N, active"
    assert shown["tension"].colour == GREEN


def test_held_tissue_shows_how_far_the_pull_may_go_and_release_ends_it(rig):
    rig.awake().finish("tense")
    (done,), (left,) = route(rig.view).travelled, route(rig.view).ahead
    assert done.end == left.start == rig.view.grasp.s
    assert left.end == rig.view.grasp.pull.length
    rig.finish("release")
    assert not route(rig.view).ahead and "tension" not in shapes(rig)


@pytest.mark.parametrize(("tension", "colour"), [(2.0, GREEN), (2.2, AMBER), (2.5, RED)])
def test_the_colour_of_the_pull_shows_its_limits(rig, tension, colour):
    rig.awake()
    pulled = replace(rig.view.measurement, force=np.array([0.0, 0.0, -tension]))
    assert shapes(rig, replace(rig.view, measurement=pulled))["tension"].colour == colour


def test_a_circle_is_round_closed_and_square_to_its_normal():
    ring = circle((0.1, 0.2, 0.3), 0.02, (1.0, -2.0, 0.5), 16)
    away = ring - [0.1, 0.2, 0.3]
    assert np.allclose(np.linalg.norm(away, axis=1), 0.02)
    assert np.allclose(away @ [1.0, -2.0, 0.5], 0.0, atol=1e-15)
    assert np.allclose(ring[0], ring[-1]) and len(ring) == 17
