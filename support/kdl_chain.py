# SPDX-License-Identifier: BSD-3-Clause
"""The robot as a chain of KDL, the reference that tests and bench compare the kernels with."""

from __future__ import annotations

import PyKDL

from rst_control.kinematics.robot_model import RobotModel


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
