# SPDX-License-Identifier: BSD-3-Clause
"""Mass, centre of mass and inertia of the links of a URDF."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree as Xml

import numpy as np
from numpy.typing import NDArray

from rst_control.kinematics.robot_model import rotation

Array = NDArray[np.float64]
NO_SHIFT = "0 0 0"  # of an origin that leaves out a row
TERMS = (("ixx", 0, 0), ("iyy", 1, 1), ("izz", 2, 2), ("ixy", 0, 1), ("ixz", 0, 2), ("iyz", 1, 2))


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body."""

    mass: float  # [kg]
    centre: Array  # (3,), [m]
    inertia: Array  # (3, 3), [kg m^2] about the centre

    def placed(self, T: Array) -> Body:
        """The same body seen from a frame in which its own has the pose T. Shape (4, 4)."""
        R = T[:3, :3]
        return Body(self.mass, R @ self.centre + T[:3, 3], R @ self.inertia @ R.T)

    def __add__(self, other: Body) -> Body:
        """Both as one, by the parallel axis theorem."""
        mass = self.mass + other.mass
        centre = (self.mass * self.centre + other.mass * other.centre) / mass
        return Body(mass, centre, self._about(centre) + other._about(centre))

    def _about(self, point: Array) -> Array:
        d = self.centre - point
        moved: Array = self.inertia + self.mass * (d @ d * np.eye(3) - np.outer(d, d))
        return moved


def link_body(link: Xml.Element) -> Body | None:
    """Body of a link in the link's frame; None: it has no mass."""
    inertial = link.find("inertial")
    if inertial is None:
        return None
    mass, terms, inertia = inertial.find("mass"), inertial.find("inertia"), np.zeros((3, 3))
    for name, i, j in TERMS:
        inertia[i, j] = inertia[j, i] = float(terms.attrib[name])  # type: ignore[union-attr]
    own = Body(float(mass.attrib["value"]), np.zeros(3), inertia)  # type: ignore[union-attr]
    return own.placed(origin_pose(inertial))


def origin_pose(element: Xml.Element) -> Array:
    """Pose that the `origin` of a joint or an inertial says. Shape (4, 4)."""
    origin, T = element.find("origin"), np.eye(4)
    if origin is not None:
        T[:3, 3] = [float(word) for word in origin.get("xyz", NO_SHIFT).split()]
        T[:3, :3] = rotation([float(word) for word in origin.get("rpy", NO_SHIFT).split()])
    return T
