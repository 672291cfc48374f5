# SPDX-License-Identifier: BSD-3-Clause
"""A robot of joined links weighs, stands and resists as the robot that it was made from."""

from __future__ import annotations

import numpy as np
import pybullet
import pytest

from rst_control.config import URDF_FILE
from rst_control.simulation.physics import joint_indices, link_indices
from rst_control.simulation.rigid_parts import joined
from rst_control.types import JOINTS

MOVED = ("bracelet_link", "pitch_link", "finger_left_link", "finger_right_link")


class World:
    """PyBullet with one model in it."""

    def __init__(self, path: str) -> None:
        self.client = pybullet.connect(pybullet.DIRECT)
        self.robot = pybullet.loadURDF(
            path,
            useFixedBase=True,
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
            physicsClientId=self.client,
        )
        self.joints = joint_indices(self.robot, self.client)
        self.links = link_indices(self.robot, self.client)

    def torques(self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> np.ndarray:
        order = np.argsort(self.joints)  # PyBullet takes and gives them in its own order
        found = np.empty(len(JOINTS))
        found[order] = pybullet.calculateInverseDynamics(
            self.robot,
            *(values[order].tolist() for values in (q, dq, ddq)),
            physicsClientId=self.client,
        )
        return found

    def place(self, link: str, q: np.ndarray) -> np.ndarray:
        for joint, angle in zip(self.joints, q, strict=True):
            pybullet.resetJointState(self.robot, joint, angle, physicsClientId=self.client)
        state = pybullet.getLinkState(
            self.robot, self.links[link], computeForwardKinematics=1, physicsClientId=self.client
        )
        return np.array([*state[4], *pybullet.getMatrixFromQuaternion(state[5])])


@pytest.fixture
def worlds(tmp_path):
    path = tmp_path / "joined.urdf"
    path.write_text(joined(URDF_FILE.read_text(encoding="utf-8")), encoding="utf-8")
    both = World(str(URDF_FILE)), World(str(path))
    for world in both:
        pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=world.client)
    yield both
    for world in both:
        pybullet.disconnect(world.client)


def test_any_motion_takes_the_same_torques(worlds):
    whole, parts = worlds
    rng = np.random.default_rng(5)
    for _ in range(50):
        q, dq, ddq = rng.uniform(-1.5, 1.5, (3, len(JOINTS)))
        torques = whole.torques(q, dq, 5.0 * ddq)
        assert np.abs(torques).max() > 1.0
        assert np.allclose(parts.torques(q, dq, 5.0 * ddq), torques, atol=1e-6)


def test_every_part_stands_where_it_stood(worlds):
    whole, parts = worlds
    rng = np.random.default_rng(6)
    for q in rng.uniform(-1.5, 1.5, (20, len(JOINTS))):
        for link in MOVED:
            assert np.allclose(parts.place(link, q), whole.place(link, q), atol=5e-7)


def test_only_links_that_move_are_left(worlds):
    whole, parts = worlds
    assert len(parts.links) == len(JOINTS) < len(whole.links)
    masses = [
        sum(
            pybullet.getDynamicsInfo(world.robot, number, physicsClientId=world.client)[0]
            for link, number in world.links.items()
            if link != "base_link"
        )
        for world in worlds
    ]
    assert masses[1] == pytest.approx(masses[0], abs=1e-9)
    assert masses[0] > 5.0


def test_an_origin_may_leave_out_a_row_that_is_zero():
    whole = URDF_FILE.read_text(encoding="utf-8")
    short = whole.replace(' rpy="0 0 0"', "")
    assert short != whole
    assert joined(short) == joined(whole)
