# SPDX-License-Identifier: BSD-3-Clause
"""The tips of the jaws by the compiled chain, against PyBullet's own kinematics."""

from __future__ import annotations

import numpy as np
import pybullet
import pytest

from rst_control.config import URDF_FILE, load_simulation_config
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.simulation import physics
from rst_control.simulation.jaw_tips import JawTips

TIPS = JawTips(load_robot())
SCENE = load_simulation_config().scene
HOME = robot_joints(np.array(SCENE.home), SCENE.home_opening)


@pytest.fixture(scope="module")
def world():
    client = pybullet.connect(pybullet.DIRECT)
    yield client, physics.load_robot(URDF_FILE, client)
    pybullet.disconnect(client)


def place(world, link: str) -> tuple[np.ndarray, np.ndarray]:
    """Where a link is in PyBullet, and how it is turned; shapes (3,) and (3, 3)."""
    client, robot = world
    number = physics.link_indices(robot, client)[link]
    state = pybullet.getLinkState(robot, number, computeForwardKinematics=1, physicsClientId=client)
    turn = pybullet.getMatrixFromQuaternion(state[5])
    return np.array(state[4]), np.reshape(turn, (3, 3))


def stand(world, joints: np.ndarray) -> None:
    client, robot = world
    for number, angle in zip(physics.joint_indices(robot, client), joints, strict=True):
        pybullet.resetJointState(robot, number, angle, physicsClientId=client)


def test_they_are_where_pybullet_has_them_to_a_tenth_of_a_micrometre(world):
    stand(world, np.zeros(10))
    length = np.array(load_robot().links["tool_tip"].xyz)  # PyBullet says places in 32 bits only
    rng = np.random.default_rng(11)
    for joints in HOME + rng.uniform(-0.7, 0.7, (300, 10)):
        stand(world, joints)
        fingers = [place(world, finger) for finger in physics.FINGERS]
        expected = np.array([origin + turn @ length for origin, turn in fingers])
        points = TIPS(joints)
        assert np.abs(points[:2] - expected).max() < 1e-7
        assert np.allclose(points[0], place(world, "tool_tip")[0], atol=1e-7)
        assert np.allclose(points[2], expected.mean(axis=0), atol=1e-7)


def test_each_jaw_moves_its_own_tip_only():
    joints = np.linspace(-0.5, 0.5, 10)
    before = TIPS(joints)
    joints[9] += 0.1
    after = TIPS(joints)
    assert np.array_equal(before[0], after[0])
    assert np.linalg.norm(after[1] - before[1]) > 5e-4
