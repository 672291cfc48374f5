# SPDX-License-Identifier: BSD-3-Clause
"""Three kinematics of one URDF, by three authors: our kernels, KDL, PyBullet."""

import numpy as np
import pybullet
import PyKDL
import pytest

from rst_control.config import URDF_FILE
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.types import JOINTS
from support.kdl_chain import kdl_chain

COUNT = 10_000
TIP_ERROR = 1e-6  # [m]
JACOBIAN_ERROR = 1e-6
KERNEL_ERROR = 1e-12


class Kdl:
    def __init__(self, model, tip):
        self._chain = kdl_chain(model, tip)  # kept: the solvers only refer to it
        self._pose = PyKDL.ChainFkSolverPos_recursive(self._chain)
        self._jacobian = PyKDL.ChainJntToJacSolver(self._chain)
        self._count = self._chain.getNrOfJoints()

    def __call__(self, q):
        joints = PyKDL.JntArray(self._count)
        for i in range(self._count):
            joints[i] = q[i]
        frame, J = PyKDL.Frame(), PyKDL.Jacobian(self._count)
        assert self._pose.JntToCart(joints, frame) == 0
        assert self._jacobian.JntToJac(joints, J) == 0
        pose = [[frame[i, j] for j in range(4)] for i in range(3)]
        return np.array(pose), np.array([[J[i, j] for j in range(self._count)] for i in range(6)])


class Bullet:
    def __init__(self, client):
        self._client = client
        self._body = pybullet.loadURDF(str(URDF_FILE), useFixedBase=True, physicsClientId=client)
        infos = [
            pybullet.getJointInfo(self._body, i, physicsClientId=client)
            for i in range(pybullet.getNumJoints(self._body, physicsClientId=client))
        ]
        self._links = {info[12].decode(): info[0] for info in infos}
        order = [info[1].decode() for info in infos if info[2] != pybullet.JOINT_FIXED]
        self._columns = [order.index(name) for name in JOINTS[:9]]
        self._order = [JOINTS.index(name) for name in order]
        self._index = {info[1].decode(): info[0] for info in infos}

    def place(self, q):
        self._joints = robot_joints(q, 0.0)
        indices = [self._index[name] for name in JOINTS]
        pybullet.resetJointStatesMultiDof(
            self._body, indices, [[value] for value in self._joints], physicsClientId=self._client
        )

    def pose(self, link):
        state = pybullet.getLinkState(
            self._body,
            self._links[link],
            computeForwardKinematics=True,
            physicsClientId=self._client,
        )
        turn = np.reshape(pybullet.getMatrixFromQuaternion(state[5]), (3, 3))
        return np.column_stack([turn, state[4]])

    def jacobian(self, link):
        still = [0.0] * len(JOINTS)
        values = [float(self._joints[i]) for i in self._order]
        linear, angular = pybullet.calculateJacobian(
            self._body,
            self._links[link],
            [0.0, 0.0, 0.0],
            values,
            still,
            still,
            physicsClientId=self._client,
        )
        return np.vstack([linear, angular])[:, self._columns]


@pytest.fixture(scope="module")
def bullet():
    client = pybullet.connect(pybullet.DIRECT)
    yield Bullet(client)
    pybullet.disconnect(client)


def random_joints(limits, count):
    rng = np.random.default_rng(7)
    return rng.uniform(
        np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi), (count, 9)
    )


def test_kernels_kdl_and_pybullet_agree_over_ten_thousand_configurations(robot, planner, bullet):
    kdl = Kdl(robot, "tool_tip")
    worst = dict.fromkeys(("kernel pose", "kernel J", "tip", "turn", "J"), 0.0)
    for q in random_joints(planner.limits, COUNT):
        ours = Configuration(robot, q)
        pose, J = kdl(q)
        bullet.place(q)
        other = bullet.pose("tool_tip")
        for name, error in (
            ("kernel pose", ours.frames[forward.TIP] - pose),
            ("kernel J", ours.J_tip - J),
            ("tip", pose[:, 3] - other[:, 3]),
            ("turn", pose[:, :3] - other[:, :3]),
            ("J", J - bullet.jacobian("tool_tip")),
        ):
            worst[name] = max(worst[name], float(np.abs(error).max()))
    assert worst["kernel pose"] < KERNEL_ERROR
    assert worst["kernel J"] < KERNEL_ERROR
    assert worst["tip"] < TIP_ERROR
    assert worst["turn"] < JACOBIAN_ERROR
    assert worst["J"] < JACOBIAN_ERROR


@pytest.mark.parametrize("link", ["tool0", "interface_link", "pitch_link"])
def test_every_named_frame_is_where_pybullet_and_kdl_see_it(robot, planner, bullet, link):
    rows = {"tool0": forward.TOOL0, "interface_link": forward.SHAFT, "pitch_link": forward.PITCH}
    kdl = Kdl(robot, link)
    for q in random_joints(planner.limits, 200):
        bullet.place(q)
        ours = Configuration(robot, q).frames[rows[link]]
        np.testing.assert_allclose(ours, kdl(q)[0], atol=KERNEL_ERROR)
        np.testing.assert_allclose(ours, bullet.pose(link), atol=TIP_ERROR)


def test_the_shaft_is_straight_and_as_long_as_thought(robot, planner):
    assert robot.shaft_length == pytest.approx(0.28, abs=1e-12)
    for q in random_joints(planner.limits, 50):
        frames = Configuration(robot, q).frames
        end = frames[forward.SHAFT, :, 3] + 0.28 * frames[forward.SHAFT, :, 2]
        np.testing.assert_allclose(end, frames[forward.PITCH, :, 3], atol=1e-12)
