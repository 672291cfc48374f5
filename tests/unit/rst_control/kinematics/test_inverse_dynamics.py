# SPDX-License-Identifier: BSD-3-Clause
"""Torques of gravity and motion, against PyBullet's inverse dynamics as independent oracle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pybullet
import pytest

from rst_control.config import URDF_FILE
from rst_control.errors import RobotModelError
from rst_control.kinematics.inverse_dynamics import InverseDynamics
from rst_control.simulation.physics import load_robot

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


def test_a_link_that_moves_without_mass_is_refused_by_name() -> None:
    start = TEXT.index('<link name="forearm_link">')
    end = TEXT.index("</inertial>", start) + len("</inertial>")
    first = TEXT.index("<inertial>", start)
    with pytest.raises(RobotModelError, match="forearm_link"):
        InverseDynamics(TEXT[:first] + TEXT[end:])
