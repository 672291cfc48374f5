# SPDX-License-Identifier: BSD-3-Clause
"""Torques that gravity and motion ask of the joints, by KDL from the masses of the URDF."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np
import PyKDL
from numpy.typing import NDArray

from rst_control.errors import RobotModelError
from rst_control.kinematics.mounting import gravity_in_base
from rst_control.kinematics.robot_model import Link, RobotModel, parse_robot, rotation
from rst_control.types import ARM_JOINTS, PLAN_COUNT, Vector

Array = NDArray[np.float64]
TIP = "tool_tip"
ARM = len(ARM_JOINTS)


class InverseDynamics:
    """Joint torques of the arm for a motion without any load, by recursive Newton-Euler.

    Links beside the way to the tool's tip, such as the second jaw, ride on it at joint angle zero.
    KDL's solver only refers to its chain, so the chain is kept here.

    Args:
        description: URDF text.
        tool_mass: Added at the middle of tool0 [kg], where the tool weighs more than the URDF says.
        gravity: Base frame [m/s^2]; None: as the URDF's root has it. Shape (3,).

    Raises:
        RobotModelError: The URDF is not this robot's, or a link that moves has no mass.
    """

    def __init__(
        self, description: str, tool_mass: float = 0.0, gravity: Vector | None = None
    ) -> None:
        self.model = parse_robot(description)
        inertias = _inertias(description)
        if tool_mass:
            tool = inertias["tool0"]
            inertias["tool0"] = tool + PyKDL.RigidBodyInertia(tool_mass, tool.getCOG())
        self._chain = _chain(self.model, inertias)
        self._count, self._rows = self._chain.getNrOfJoints(), _moving_rows(self.model)
        self.gravity = gravity_in_base(self.model) if gravity is None else gravity
        self._solver = PyKDL.ChainIdSolver_RNE(self._chain, PyKDL.Vector(*self.gravity.tolist()))
        self._loads = [PyKDL.Wrench() for _ in range(self._chain.getNrOfSegments())]

    def __call__(self, q: Vector, dq: Vector | None = None, ddq: Vector | None = None) -> Vector:
        """Torques of the arm's joints.

        Args:
            q: Planning configuration [rad]. Shape (9,).
            dq: Its velocity [rad/s]; None: at rest. Shape (9,).
            ddq: Its acceleration [rad/s^2]; None: none. Shape (9,).

        Returns:
            Torques that the motors give [N m]. Shape (7,).
        """
        torques, still = PyKDL.JntArray(self._count), np.zeros(PLAN_COUNT)
        motion = (q, still if dq is None else dq, still if ddq is None else ddq)
        positions, speeds, accelerations = (self._array(values) for values in motion)
        code = self._solver.CartToJnt(positions, speeds, accelerations, self._loads, torques)
        if code != 0:
            raise RobotModelError(f"KDL's inverse dynamics gave up with code {code}")
        spread = np.zeros(PLAN_COUNT)
        spread[self._rows] = [torques[j] for j in range(self._count)]
        return spread[:ARM]

    def _array(self, values: Vector) -> Any:
        array = PyKDL.JntArray(self._count)
        for j, number in enumerate(self._rows):
            array[j] = float(values[number])
        return array


def _moving_rows(model: RobotModel) -> list[int]:
    """Numbers in q of the joints on the way to the tip that can turn."""
    names = (*ARM_JOINTS, "joint_pitch", "joint_finger_left")
    turning = [model.links[name] for name in model.route(TIP)]
    return [names.index(link.joint) for link in turning if link.type != "fixed"]


def _chain(model: RobotModel, inertias: Mapping[str, Any]) -> Any:
    """KDL chain to the tip in which each segment carries what hangs on it."""
    route, chain = model.route(TIP), PyKDL.Chain()
    loads = {name: inertias.get(name, PyKDL.RigidBodyInertia()) for name in route}
    for name, inertia in inertias.items():
        place, T = name, PyKDL.Frame()
        while place in model.links and place not in loads:
            T = _frame(model.links[place]) * T
            place = model.links[place].parent
        if place != name and place in loads:
            loads[place] = loads[place] + T * inertia
    for name in route:
        link, frame = model.links[name], _frame(model.links[name])
        kind = PyKDL.Joint(link.joint, PyKDL.Joint.Fixed)
        if link.type != "fixed":
            if loads[name].getMass() <= 0.0:
                raise RobotModelError(f"link {name} moves and has no mass, allowed: above 0 kg")
            axis = frame.M * PyKDL.Vector(0.0, 0.0, 1.0)
            kind = PyKDL.Joint(link.joint, frame.p, axis, PyKDL.Joint.RotAxis)
        chain.addSegment(PyKDL.Segment(name, kind, frame, loads[name]))
    return chain


def _frame(link: Link) -> Any:
    return PyKDL.Frame(PyKDL.Rotation.RPY(*link.rpy), PyKDL.Vector(*link.xyz))


def _inertias(description: str) -> dict[str, Any]:
    """Mass, centre and inertia of each link that has any, in the link's frame."""
    found = {}
    for link in Xml.fromstring(description).findall("link"):
        inertial = link.find("inertial")
        if inertial is not None:
            found[str(link.get("name"))] = _inertia(inertial)
    return found


def _inertia(inertial: Xml.Element) -> Any:
    """KDL wants the inertia about the centre of mass, along the axes of the link."""
    parts = {part.tag: part.attrib for part in inertial}
    values = {name: float(value) for name, value in parts["inertia"].items()}
    I = np.array(  # noqa: E741 - the symbol of the field
        [
            [values["ixx"], values["ixy"], values["ixz"]],
            [values["ixy"], values["iyy"], values["iyz"]],
            [values["ixz"], values["iyz"], values["izz"]],
        ]
    )
    origin = parts.get("origin", {})
    centre = [float(word) for word in origin.get("xyz", "0 0 0").split()]
    R = rotation([float(word) for word in origin.get("rpy", "0 0 0").split()])
    I = R @ I @ R.T  # noqa: E741
    tensor = PyKDL.RotationalInertia(I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2])
    return PyKDL.RigidBodyInertia(float(parts["mass"]["value"]), PyKDL.Vector(*centre), tensor)
