# SPDX-License-Identifier: BSD-3-Clause
"""The 6-DoF arm of examples/ur5e_openrst, and its shaft as PyBullet and KDL see it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pybullet
import PyKDL

from rst_control.config import CONFIG_FOLDER, MotionConfig
from rst_control.kinematics.rcm import rcm_error_vector
from rst_control.kinematics.robot_model import RobotModel, load_robot
from rst_control.types import JOINTS
from support.kdl_chain import kdl_chain
from typed_config import load_config, load_yaml, overlaid

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "ur5e_openrst"
URDF = EXAMPLE / "robot.urdf"
SECTIONS = ("limits", "rcm", "scene", "controller", "collision")


@cache
def example() -> tuple[MotionConfig, RobotModel]:
    """Settings, as `controller.launch overrides:=...` puts them together, and the model."""
    base = {name: load_yaml(CONFIG_FOLDER / f"{name}.yaml") for name in SECTIONS}
    settings = overlaid(base, load_yaml(EXAMPLE / "settings.yaml"))
    return load_config(MotionConfig, settings, "settings.yaml"), load_robot(URDF)


class KdlShaft:
    """Both ends of the shaft, by KDL."""

    def __init__(self, model: RobotModel) -> None:
        self._chains = [kdl_chain(model, name) for name in ("interface_link", "pitch_link")]
        self._solvers = [PyKDL.ChainFkSolverPos_recursive(chain) for chain in self._chains]

    def error(self, joints: np.ndarray, trocar: np.ndarray) -> float:
        """Distance of the shaft's line from the trocar [m] for robot joints (10,) [rad]."""
        turning = np.delete(joints[:8], 6)  # joint_1 to joint_6, pitch
        ends = []
        for chain, solver in zip(self._chains, self._solvers, strict=True):
            array, frame = PyKDL.JntArray(chain.getNrOfJoints()), PyKDL.Frame()
            for j in range(array.rows()):
                array[j] = float(turning[j])
            assert solver.JntToCart(array, frame) == 0
            ends.append(np.array(list(frame.p)))
        return shaft_error(ends[0], ends[1], trocar)


class BulletShaft:
    """The same by PyBullet, which knows nothing of our model."""

    def __init__(self) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        self._on = {"physicsClientId": self._client}
        self._robot = pybullet.loadURDF(str(URDF), useFixedBase=True, **self._on)
        count = pybullet.getNumJoints(self._robot, **self._on)
        info = [pybullet.getJointInfo(self._robot, j, **self._on) for j in range(count)]
        self._joints = {entry[1].decode(): entry[0] for entry in info}
        links = {entry[12].decode(): entry[0] for entry in info}
        self._ends = [links["interface_link"], links["pitch_link"]]

    def error(self, joints: np.ndarray, trocar: np.ndarray) -> float:
        """Distance of the shaft's line from the trocar [m] for robot joints (10,) [rad]."""
        for name, angle in zip(JOINTS, joints, strict=True):
            pybullet.resetJointState(self._robot, self._joints[name], float(angle), **self._on)
        states = pybullet.getLinkStates(
            self._robot, self._ends, computeForwardKinematics=1, **self._on
        )
        return shaft_error(np.array(states[0][4]), np.array(states[1][4]), trocar)

    def close(self) -> None:
        """End PyBullet."""
        pybullet.disconnect(self._client)


def shaft_error(start: np.ndarray, end: np.ndarray, trocar: np.ndarray) -> float:
    """Distance [m] of the line through two points (3,) from a third."""
    along = (end - start) / np.linalg.norm(end - start)
    return float(np.linalg.norm(rcm_error_vector(start, along, trocar)))
