# SPDX-License-Identifier: BSD-3-Clause
"""The robot's collision bodies as PyBullet sees them: distances by an independent library."""

from __future__ import annotations

import numpy as np
import pybullet
from numpy.typing import NDArray

from bench.motion.bullet.robot import BulletRobot
from rst_control.config.collision import BodyConfig, CollisionConfig
from rst_control.kinematics.configuration import robot_joints
from rst_control.types import unit_vector

Array = NDArray[np.float64]
NO_TURN = (0.0, 0.0, 0.0, 1.0)
FAR = 5.0  # [m] within which distances are measured
STANDING = ("base_link", "shoulder_link")  # at one height in every configuration
Found = tuple[float, frozenset[str]]  # [m], and the names of the two


class BulletBodies(BulletRobot):
    """Capsules hung on PyBullet's own robot; a context manager.

    Args:
        config: The bodies, what is left out, and the table.
    """

    def __init__(self, config: CollisionConfig) -> None:
        super().__init__()
        self._config = config
        self._bodies = [self._make(body) for body in config.bodies]
        self._ends = np.zeros((len(self._bodies), 2, 3))
        apart = {frozenset((e.link, o)) for e in config.left_out for o in e.others}
        self._pairs = [
            (a, b)
            for a, first in enumerate(config.bodies)
            for b, second in enumerate(config.bodies[:a])
            if first.link != second.link and frozenset((first.link, second.link)) not in apart
        ]

    def nearest(self, q: Array) -> Found:
        """The two that are nearest, of all that must keep apart, at q (9,) [rad]."""
        return min(self.distances(q), key=lambda found: found[0])

    def distances(self, q: Array) -> list[Found]:
        """All that must keep apart, with their distances, at q (9,) [rad]."""
        self._place(q)
        bodies, found = self._config.bodies, []
        for a, b in self._pairs:
            names = frozenset((bodies[a].name, bodies[b].name))
            found.append((self._distance(self._bodies[a], self._bodies[b]), names))
        if self._config.has_table:
            normal = unit_vector(self._config.table_normal)
            lowest = (self._ends @ normal).min(axis=1) - self._config.table_height
            for body, height in zip(bodies, lowest, strict=True):
                if body.link not in STANDING:
                    names = frozenset((body.name, "table"))
                    found.append((float(height) - body.radius, names))
        return found

    def _make(self, body: BodyConfig) -> int:
        length = float(np.linalg.norm(np.subtract(body.end, body.start)))
        if length > 0.0:
            kind, more = pybullet.GEOM_CAPSULE, {"height": length}
        else:
            kind, more = pybullet.GEOM_SPHERE, {}
        shape = pybullet.createCollisionShape(
            kind, radius=body.radius, physicsClientId=self._client, **more
        )
        number: int = pybullet.createMultiBody(
            baseCollisionShapeIndex=shape, physicsClientId=self._client
        )
        return number

    def _place(self, q: Array) -> None:
        self.place(robot_joints(q, 0.0))
        links = {body.link for body in self._config.bodies}
        poses = {link: self._pose(link) for link in links}
        for n, (number, body) in enumerate(zip(self._bodies, self._config.bodies, strict=True)):
            position, turn = poses[body.link]
            middle = 0.5 * np.add(body.start, body.end)
            at, turned = pybullet.multiplyTransforms(position, turn, middle, _along(body))
            pybullet.resetBasePositionAndOrientation(
                number, at, turned, physicsClientId=self._client
            )
            for k, end in enumerate((body.start, body.end)):
                self._ends[n, k] = pybullet.multiplyTransforms(position, turn, end, NO_TURN)[0]

    def _pose(self, link: str) -> tuple[Array, Array]:
        if link == "base_link":
            return np.zeros(3), np.array(NO_TURN)
        state = pybullet.getLinkState(
            self._robot,
            self._links[link],
            computeForwardKinematics=True,
            physicsClientId=self._client,
        )
        return np.array(state[4]), np.array(state[5])

    def _distance(self, a: int, b: int) -> float:
        points = pybullet.getClosestPoints(a, b, FAR, physicsClientId=self._client)
        return min(float(point[8]) for point in points)


def _along(body: BodyConfig) -> Array:
    """Quaternion that turns z, along which a capsule of PyBullet lies, to the body's line."""
    line = np.subtract(body.end, body.start)
    length = float(np.linalg.norm(line))
    if length == 0.0:
        return np.array(NO_TURN)
    x, y, z = line / length
    if z < -1.0 + 1e-12:
        return np.array([1.0, 0.0, 0.0, 0.0])
    quaternion = np.array([-y, x, 0.0, 1.0 + z])
    found: Array = quaternion / np.linalg.norm(quaternion)
    return found
