# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace
from math import nan

import numpy as np
import pytest

from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.robot_model import parse_robot
from rst_control.planning.patient_surface import NOWHERE, Patient, TrocarPose
from tests.unit.rst_control.support.renamed_links import renamed_shapes, renamed_urdf

FLOAT_NOISE = 2e-6  # [m] of PyBullet's poses
WATCHED = 0.5  # of the margin


@pytest.fixture(scope="module")
def patient(planner):
    return planner.patient


def anywhere(planner, count, seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(planner.limits.lower, planner.limits.upper, (count, 9))


def near_home(planner, home, count, seed):
    rng = np.random.default_rng(seed)
    return home + rng.normal(0.0, 0.1, (count, 9))


def test_placement_is_what_pybullet_says(planner, home, patient, witness):
    for q in [*anywhere(planner, 200, 1), *near_home(planner, home, 200, 2)]:
        place, sight = patient.trocar_pose(q), witness.observe(q)
        assert place.error == pytest.approx(sight.error, abs=FLOAT_NOISE)
        assert place.wrist == pytest.approx(sight.wrist, abs=FLOAT_NOISE)
        assert place.height == pytest.approx(min(sight.tool, sight.arm), abs=FLOAT_NOISE)


def test_only_a_robot_wholly_outside_counts_as_outside(planner, home, patient, witness):
    margin, seen = WATCHED * planner.config.scene.surface_margin, {True: 0, False: 0}
    for q in [*anywhere(planner, 400, 3), *near_home(planner, home, 100, 4)]:
        place, sight = patient.trocar_pose(q), witness.observe(q)
        lowest = min(sight.tool, sight.arm)
        if abs(lowest - margin) > FLOAT_NOISE:
            assert place.is_outside == (lowest > margin)
            seen[place.is_outside] += 1
    assert min(seen.values()) > 50


def test_at_home_the_tool_is_inside_by_what_the_scene_says(home, patient):
    place = patient.trocar_pose(home)
    assert not place.is_outside
    assert place.error < 1e-9
    assert place.insertion > place.wrist > 0.09
    assert place.rcm_error == place.error


def test_insertion_is_negative_wherever_the_robot_is_outside(planner, patient):
    outside = [p for p in map(patient.trocar_pose, anywhere(planner, 500, 5)) if p.is_outside]
    assert len(outside) > 100
    assert all(p.insertion < 0.0 for p in outside)
    assert all(p.rcm_error == 0.0 for p in outside)


def test_what_is_no_number_is_never_outside(patient):
    for joint in range(9):
        assert not patient.trocar_pose(np.where(np.arange(9) == joint, nan, 0.0)).is_outside
    assert not NOWHERE.is_outside
    assert np.isnan(NOWHERE.rcm_error)


def test_the_surface_goes_through_the_trocar_square_to_outward(planner, home):
    config = planner.config
    aslant = replace(config.scene, outward=(-2.0, 0.0, 2.0))
    tilted = Patient(planner.model, replace(config, scene=aslant))
    np.testing.assert_allclose(tilted.outward, np.array([-1.0, 0.0, 1.0]) / np.sqrt(2.0))
    tip = Configuration(planner.model, home).tip - np.array(config.scene.trocar)
    below = float(tip @ tilted.outward) - tilted.trocar_pose(home).height
    assert 0.015 <= below <= 0.017  # the jaws' capsule round the tip


def test_a_placement_outside_has_no_rcm_error_and_any_other_has():
    inside = TrocarPose(error=2e-3, insertion=0.1, wrist=0.08, height=-0.1, is_outside=False)
    assert inside.rcm_error == 2e-3
    assert replace(inside, is_outside=True).rcm_error == 0.0


def test_links_of_any_name_may_turn_on_the_spot_or_pass_the_trocar(planner, home, patient):
    config = replace(planner.config, collision=renamed_shapes(planner.config.collision))
    renamed = Patient(parse_robot(renamed_urdf()), config)
    assert renamed.min_standoff == patient.min_standoff
    for q in [home, *anywhere(planner, 100, 7), *near_home(planner, home, 100, 8)]:
        assert renamed.trocar_pose(q) == patient.trocar_pose(q)
        assert renamed.passing.clearance(q) == patient.passing.clearance(q)
        assert renamed.outside.clearance(q) == patient.outside.clearance(q)
    assert renamed.passing.clearance(home).distance > 0.0
    assert renamed.outside.clearance(home).distance < 0.0
