# SPDX-License-Identifier: BSD-3-Clause
"""Torques that gravity and motion ask of the joints, by KDL from the masses of the URDF."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np
import PyKDL

from rst_control.errors import RobotModelError
from rst_control.kinematics.body import TERMS, Body, link_body
from rst_control.kinematics.mounting import gravity_in_base
from rst_control.kinematics.robot_model import MOVING, Link, RobotModel, parse_robot
from rst_control.types import ARM_COUNT, PLAN_COUNT, Vector

TIP = "tool_tip"


class InverseDynamics:
    """Joint torques of the arm for a motion without any load, by recursive Newton-Euler.

    Links beside the way to the tool's tip, such as the second jaw, ride on it at joint angle zero.
    KDL's solver only refers to its chain, so the chain is kept here.

    Args:
        description: URDF text.
        tool_mass: What the tool weighs beyond the URDF's mass [kg]. It is added at the centre of
            mass of tool0, or at its origin where the URDF gives tool0 no mass.
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
            tool = inertias.get("tool0", PyKDL.RigidBodyInertia())
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
        return spread[:ARM_COUNT]

    def _array(self, values: Vector) -> Any:
        array = PyKDL.JntArray(self._count)
        for j, number in enumerate(self._rows):
            array[j] = float(values[number])
        return array


def _moving_rows(model: RobotModel) -> list[int]:
    """Numbers in q of the joints on the way to the tip that can turn."""
    route = [model.links[name] for name in model.route(TIP)]
    return [MOVING.index(link.joint) for link in route if link.type != "fixed"]


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
    """KDL's inertia of each link that has a mass, in the link's frame."""
    links = Xml.fromstring(description).findall("link")
    bodies = {str(link.get("name")): link_body(link) for link in links}
    return {name: _inertia(body) for name, body in bodies.items() if body is not None}


def _inertia(body: Body) -> Any:
    """KDL takes the inertia about the centre of mass, along the axes of the link."""
    tensor = PyKDL.RotationalInertia(*(body.inertia[i, j] for _, i, j in TERMS))
    return PyKDL.RigidBodyInertia(body.mass, PyKDL.Vector(*body.centre.tolist()), tensor)
