# SPDX-License-Identifier: BSD-3-Clause
"""Torques at rest against gravity's: an arm that is mounted otherwise than set is found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import URDF_FILE, load_motion_config
from rst_control.config.torque_tension import load_torque_tension
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.inverse_dynamics import InverseDynamics
from rst_control.tension.gravity_check import READINGS, RestTorques
from rst_control.tension.torque_estimator import TorqueTension, load_matrix
from rst_control.types import Measurement, unit_vector

TEXT = URDF_FILE.read_text(encoding="utf-8")
SCENE = load_motion_config().scene
HOME, TROCAR = np.array(SCENE.home), np.array(SCENE.trocar)
CONFIG = load_torque_tension()
STAND_IN_OFFSET = np.array([0.30, -0.40, 0.25, 0.40, -0.10, 0.08, 0.05])  # [N m]
MOUNTINGS = {
    "30 deg": (0.5, 0.0, -0.866),
    "30 deg sideways": (0.0, 0.5, -0.866),
    "wall": (1.0, 0.0, 0.0),
    "wall, other way up": (0.0, 1.0, 0.0),
    "ceiling": (0.0, 0.0, 1.0),
}
mountings = pytest.mark.parametrize("way", MOUNTINGS.values(), ids=MOUNTINGS)


def dynamics(way) -> InverseDynamics:
    return InverseDynamics(TEXT, 0.0, 9.81 * unit_vector(way))


def rested(check, effort, velocity=0.0) -> str:
    """What is refused after readings at home."""
    for _ in range(READINGS):
        check.update(robot_joints(HOME, 0.0), np.full(7, velocity), effort)
    return check.refusal


def refusal(setting, effort, velocity=0.0, config=CONFIG) -> str:
    return rested(RestTorques(config, TEXT, setting), effort, velocity)


@mountings
def test_an_arm_mounted_as_set_may_move_although_its_torques_have_offsets(way) -> None:
    assert refusal(way, dynamics(way)(HOME) + STAND_IN_OFFSET) == ""


@mountings
def test_an_arm_set_upright_that_is_not_is_refused_with_the_numbers(way) -> None:
    words = refusal((), dynamics(way)(HOME))
    assert "do not fit gravity along [0.000, 0.000, -1.000]: joint_" in words
    nearest = ", ".join(f"{x:.3f}" for x in unit_vector(way))
    assert f"Nearest is [{nearest}]" in words
    assert "scene.gravity" in words


def test_no_torques_and_torques_of_the_other_sign_are_refused() -> None:
    words = refusal((), np.zeros(7))
    assert "joint_4 gives 0.00 N m, expected -7.1" in words
    assert "They are too small for any gravity: check scene.gravity" in words
    effort = dynamics((0, 0, -1))(HOME)
    assert "Nearest is [0.000, 0.000, -1.000], 0 deg from it" in refusal((), 0.5 * effort)
    hint = "If the base is not mounted so, the sign is wrong: effort_sign"
    assert hint in refusal((), -effort)
    assert hint not in refusal((), dynamics((0.5, 0, -0.866))(HOME))
    assert refusal((), -effort, config=replace(CONFIG, effort_sign=-1)) == ""


def test_nothing_is_known_before_the_arm_has_rested_and_a_payload_set_right_is_taken() -> None:
    effort = dynamics((0, 0, -1))(HOME)
    assert "not compared" in refusal((), effort, velocity=0.1)
    check = RestTorques(CONFIG, TEXT, ())
    assert rested(check, 3.0 * effort)
    assert rested(check, effort) == ""


def estimated(setting, way, turned, pull) -> tuple[float, str]:
    """Tension and why it is invalid, tared at home, of an arm turned from there by angles [rad]."""
    estimator, true = TorqueTension(CONFIG, TEXT, replace(SCENE, gravity=setting)), dynamics(way)
    across = unit_vector(SCENE.pull_direction)
    for k in range(120):
        is_held = k >= 60
        q = HOME + (turned if is_held else 0.0)
        A = load_matrix(true.model, q, TROCAR, across)
        effort = true(q) + A @ [pull * is_held, 0.0, 0.0]
        joints = robot_joints(q, 0.0 if is_held else 0.6)
        reading = Measurement(
            joints, np.zeros(10), np.append(effort, np.zeros(3)), 0.025 * k, gripped=is_held
        )
        found = estimator.update(reading, TROCAR)
    return found.tension, found.tension_invalid_reason


@mountings
def test_a_pull_is_found_however_the_arm_is_mounted(way) -> None:
    turned = np.array([0.2, 0.1, 0.2, -0.15, 0.2, 0.1, 0.0, 0.0, 0.0])
    for pull in (0.0, 1.0, 2.0):
        tension, _ = estimated(way, way, turned, pull)
        assert tension == pytest.approx(pull, abs=0.02)


@mountings
def test_an_arm_mounted_otherwise_gets_no_trusted_tension(way) -> None:
    _, invalid = estimated((), way, np.zeros(9), 1.0)
    assert "do not fit gravity" in invalid or "change effort_sign" in invalid
