# SPDX-License-Identifier: BSD-3-Clause
"""Where tool and arm are towards trocar and patient, by PyBullet's forward kinematics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.motion.bullet.robot import BulletRobot
from rst_control.config import MotionConfig
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.rcm import rcm_error_vector

Array = NDArray[np.float64]
TOOL = ("interface_link", "pitch_link", "finger_left_link")
STANDING = ("base_link", "shoulder_link")  # they do not move from where they are
PLACES = ("interface_link", "pitch_link", "tool_tip")


@dataclass(frozen=True)
class Sight:
    """What PyBullet says of one configuration."""

    error: float  # [m] of the shaft's line from the trocar
    tip: float  # [m] of the tip beyond the trocar, along the shaft
    wrist: float  # [m] of the wrist beyond it
    tool: float  # [m] lowest point of shaft, wrist and jaws above the patient's surface
    arm: float  # [m] lowest point of all else that moves


class BulletWitness(BulletRobot):
    """PyBullet's robot with the shapes of collision.yaml; a context manager.

    Args:
        config: Scene and shapes.
    """

    def __init__(self, config: MotionConfig) -> None:
        super().__init__()
        self._bodies = [body for body in config.collision.bodies if body.link not in STANDING]
        self._names = sorted({body.link for body in self._bodies} | set(PLACES))
        self._trocar = np.array(config.scene.trocar)
        self._outward = np.array(config.scene.outward) / np.linalg.norm(config.scene.outward)

    def observe(self, q: Array) -> Sight:
        """Measure the robot at q (9,) [rad], jaws closed."""
        self.place(robot_joints(q, 0.0))
        poses = dict(zip(self._names, self.poses(self._names), strict=True))
        first, wrist, tip = (poses[name][:, 3] for name in PLACES)
        along = (wrist - first) / np.linalg.norm(wrist - first)
        lowest = {True: np.inf, False: np.inf}
        for body in self._bodies:
            T, is_tool = poses[body.link], body.link in TOOL
            for end in (body.start, body.end):
                place = T[:, :3] @ np.array(end) + T[:, 3]
                height = float(self._outward @ (place - self._trocar)) - body.radius
                lowest[is_tool] = min(lowest[is_tool], height)
        error = float(np.linalg.norm(rcm_error_vector(first, along, self._trocar)))
        depths = (float(along @ (place - self._trocar)) for place in (tip, wrist))
        return Sight(error, *depths, lowest[True], lowest[False])
