# SPDX-License-Identifier: BSD-3-Clause
"""The robot as a chain of KDL, the reference that tests and bench compare the kernels with."""

from __future__ import annotations

import numpy as np
import PyKDL
from numpy.typing import NDArray

from rst_control.kinematics.robot_model import RobotModel

Array = NDArray[np.float64]


def kdl_chain(model: RobotModel, tip: str) -> PyKDL.Chain:
    """PyKDL chain from base_link to a link; Debian has no kdl_parser for Python.

    KDL's solvers only refer to their chain, so keep it as long as them.
    """
    chain = PyKDL.Chain()
    for name in model.route(tip):
        link = model.links[name]
        frame = PyKDL.Frame(PyKDL.Rotation.RPY(*link.rpy), PyKDL.Vector(*link.xyz))
        if link.type == "fixed":
            joint = PyKDL.Joint(link.joint, PyKDL.Joint.Fixed)
        else:  # KDL turns about an axis of the parent, which here goes through the link's origin
            axis = frame.M * PyKDL.Vector(0.0, 0.0, 1.0)
            joint = PyKDL.Joint(link.joint, frame.p, axis, PyKDL.Joint.RotAxis)
        chain.addSegment(PyKDL.Segment(name, joint, frame))
    return chain


class Kdl:
    """Forward kinematics and Jacobian of the robot's chain to a link."""

    def __init__(self, model: RobotModel, tip: str) -> None:
        self._chain = kdl_chain(model, tip)
        self._count = self._chain.getNrOfJoints()
        self._forward = PyKDL.ChainFkSolverPos_recursive(self._chain)
        self._solver = PyKDL.ChainJntToJacSolver(self._chain)

    def frame(self, q: Array) -> Array:
        """Pose of the link (4, 4), base frame; of q (n,) [rad] the chain's own joints count."""
        found, T = PyKDL.Frame(), np.eye(4)
        self._forward.JntToCart(self._joints(q), found)
        for i in range(3):
            T[i, 3] = found.p[i]
            for j in range(3):
                T[i, j] = found.M[i, j]
        return T

    def jacobian(self, q: Array) -> Array:
        """Jacobian (6, n) of the link, base frame."""
        found = PyKDL.Jacobian(self._count)
        self._solver.JntToJac(self._joints(q), found)
        return np.array([[found[i, j] for j in range(self._count)] for i in range(6)])

    def _joints(self, q: Array) -> PyKDL.JntArray:
        array = PyKDL.JntArray(self._count)
        for j in range(self._count):
            array[j] = float(q[j])
        return array
