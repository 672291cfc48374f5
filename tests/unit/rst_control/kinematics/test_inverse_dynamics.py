# SPDX-License-Identifier: BSD-3-Clause
"""Torques of gravity and motion, against PyBullet's inverse dynamics as independent oracle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pybullet
import pytest

from rst_control.config import URDF_FILE
from rst_control.errors import RobotModelError
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.inverse_dynamics import InverseDynamics
from rst_control.kinematics.mounting import GRAVITY
from rst_control.kinematics.robot_model import load_robot as load_model
from rst_control.simulation.physics import load_robot
from rst_control.simulation.plant.loads import add_load
from rst_control.types import ARM_COUNT

TEXT = URDF_FILE.read_text(encoding="utf-8")


@pytest.fixture
def world() -> Iterator[tuple[int, int]]:
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=client)
    yield load_robot(URDF_FILE, client), client
    pybullet.disconnect(client)


def test_torques_of_gravity_and_motion_are_those_of_pybullet(world: tuple[int, int]) -> None:
    robot, client = world
    dynamics, rng = InverseDynamics(TEXT), np.random.default_rng(3)
    for _ in range(20):
        q, dq, ddq = rng.uniform(-1.5, 1.5, (3, 9))
        rows = [[*row, still] for row, still in ((q, 0.0), (dq, 0.0), (ddq, 0.0))]
        asked = pybullet.calculateInverseDynamics(robot, *rows, physicsClientId=client)
        np.testing.assert_allclose(dynamics(q, dq, ddq), asked[:7], atol=1e-9)


def test_a_heavier_tool_asks_for_more_of_the_shoulder() -> None:
    q = np.array([0.0, 1.2, 0.0, 0.5, 0.0, 0.3, 0.0, 0.0, 0.0])
    light, heavy = InverseDynamics(TEXT), InverseDynamics(TEXT, tool_mass=0.5)
    assert abs(heavy(q)[1]) > abs(light(q)[1]) + 1.0


def massless(link: str) -> str:
    """The URDF with the mass of a link taken out."""
    start = TEXT.index("<inertial>", TEXT.index(f'<link name="{link}">'))
    return TEXT[:start] + TEXT[TEXT.index("</inertial>", start) + len("</inertial>") :]


def test_a_link_that_moves_without_mass_is_refused_by_name() -> None:
    with pytest.raises(RobotModelError, match="forearm_link"):
        InverseDynamics(massless("forearm_link"))


def test_where_tool0_has_no_mass_a_tool_is_added_at_its_origin() -> None:
    q, text = np.array([0.3, 1.2, -0.4, 0.5, 0.2, 0.3, 0.1, 0.0, 0.0]), massless("tool0")
    added = InverseDynamics(text, tool_mass=0.5)(q) - InverseDynamics(text)(q)
    model, expected = load_model(), np.zeros(9)
    frames = Configuration(model, q).frames
    weight = np.array([0.0, 0.0, -0.5 * GRAVITY])
    add_load(frames, ARM_COUNT, frames[forward.TOOL0, :, 3], weight, expected)
    np.testing.assert_allclose(added, -expected[:ARM_COUNT], atol=1e-9)
