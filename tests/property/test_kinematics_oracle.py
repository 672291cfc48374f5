# SPDX-License-Identifier: BSD-3-Clause
"""Three kinematics of one URDF, by three authors: our kernels, KDL, PyBullet."""

import numpy as np
import pybullet
import pytest

from bench.motion.bullet.robot import BulletRobot
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.types import JOINTS
from support.kdl_chain import Kdl

COUNT = 10_000
TIP_ERROR = 1e-6  # [m]
JACOBIAN_ERROR = 1e-6
KERNEL_ERROR = 1e-12


class Bullet(BulletRobot):
    def pose(self, q, link):
        self.place(robot_joints(q, 0.0))
        return self.poses([link])[0]

    def jacobian(self, q, link):
        """By its joints in PyBullet's order; of it those of the planning joints. Shape (6, 9)."""
        order = np.argsort(self._joints)
        still = [0.0] * len(JOINTS)
        linear, angular = pybullet.calculateJacobian(
            self._robot,
            self._links[link],
            [0.0, 0.0, 0.0],
            robot_joints(q, 0.0)[order].tolist(),
            still,
            still,
            physicsClientId=self._client,
        )
        return np.vstack([linear, angular])[:, np.argsort(order)[:9]]


@pytest.fixture(scope="module")
def bullet():
    with Bullet() as robot:
        yield robot


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
        pose, J = kdl.frame(q)[:3], kdl.jacobian(q)
        other = bullet.pose(q, "tool_tip")
        for name, error in (
            ("kernel pose", ours.frames[forward.TIP] - pose),
            ("kernel J", ours.J_tip - J),
            ("tip", pose[:, 3] - other[:, 3]),
            ("turn", pose[:, :3] - other[:, :3]),
            ("J", J - bullet.jacobian(q, "tool_tip")),
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
        ours = Configuration(robot, q).frames[rows[link]]
        np.testing.assert_allclose(ours, kdl.frame(q)[:3], atol=KERNEL_ERROR)
        np.testing.assert_allclose(ours, bullet.pose(q, link), atol=TIP_ERROR)


def test_the_shaft_is_straight_and_as_long_as_thought(robot, planner):
    assert robot.shaft_length == pytest.approx(0.28, abs=1e-12)
    for q in random_joints(planner.limits, 50):
        frames = Configuration(robot, q).frames
        end = frames[forward.SHAFT, :, 3] + 0.28 * frames[forward.SHAFT, :, 2]
        np.testing.assert_allclose(end, frames[forward.PITCH, :, 3], atol=1e-12)
