# SPDX-License-Identifier: BSD-3-Clause
"""Poses of a link from joint positions, along the URDF that the recording holds."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from session_log.errors import SessionLogError
from session_log.report.session.session_data import Track

Array = NDArray[np.float64]
TURNING, SLIDING = ("revolute", "continuous"), ("prismatic",)


class ModelUnfit(SessionLogError):
    """The recorded robot model does not lead from one link to the other."""

    def __init__(self, why: str) -> None:
        super().__init__(f"the recorded robot model does not fit: {why}")
        self.why = why


def poses(urdf: str, base: str, link: str, q: Mapping[str, Track]) -> Array:
    """Poses of `link` in `base` for joint positions over time.

    Args:
        urdf: Text of the robot model.
        base: Name of the link in whose frame the poses are.
        link: Name of the link; below `base` in the tree.
        q: Position of each joint that moves, by name, [rad] or [m]. Each of shape (n,).

    Returns:
        Homogeneous transforms. Shape (n, 4, 4).

    Raises:
        ModelUnfit: The URDF cannot be read, has no such link, or moves by an unknown joint.
    """
    count = len(next(iter(q.values()), ()))
    T_base_link = np.broadcast_to(np.eye(4), (count, 4, 4))
    for joint in _chain(urdf, base, link):
        T_base_link = T_base_link @ _origin(joint) @ _motion(joint, q, count)
    return T_base_link


def _chain(urdf: str, base: str, link: str) -> list[Element]:
    """Joints from `base` down to `link`."""
    try:
        parents = {_end(j, "child"): j for j in ElementTree.fromstring(urdf).findall("joint")}
    except ElementTree.ParseError as error:
        raise ModelUnfit(f"it is no URDF ({error})") from error
    found: list[Element] = []
    name = link
    while name != base:
        if name not in parents or len(found) > len(parents):
            raise ModelUnfit(f"no joints lead from {base} to {link}")
        found.append(parents[name])
        name = _end(parents[name], "parent")
    return found[::-1]


def _end(joint: Element, which: str) -> str:
    end = joint.find(which)
    return "" if end is None else end.get("link", "")


def _origin(joint: Element) -> Array:
    origin = joint.find("origin")
    place = np.eye(4)
    if origin is not None:
        place[:3, 3] = _numbers(origin.get("xyz", "0 0 0"))
        rpy = _numbers(origin.get("rpy", "0 0 0"))
        place[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
    return place


def _motion(joint: Element, q: Mapping[str, Track], count: int) -> Array:
    kind, name = joint.get("type", ""), joint.get("name", "")
    moved = np.tile(np.eye(4), (count, 1, 1))
    if kind == "fixed":
        return moved
    if kind not in TURNING + SLIDING:
        raise ModelUnfit(f"joint {name} is {kind}, not fixed, revolute, continuous or prismatic")
    if name not in q:
        raise ModelUnfit(f"joint {name} is not among the recorded joints")
    axis = joint.find("axis")
    direction = _numbers("1 0 0" if axis is None else axis.get("xyz", "1 0 0"))
    way = q[name][:, None] * (direction / np.linalg.norm(direction))  # (n, 3)
    if kind in TURNING:
        moved[:, :3, :3] = Rotation.from_rotvec(way).as_matrix()
    else:
        moved[:, :3, 3] = way
    return moved


def _numbers(words: str) -> Array:
    try:
        found = np.array([float(word) for word in words.split()])
    except ValueError as error:
        raise ModelUnfit(f"{words!r} should be three numbers") from error
    if found.shape != (3,) or not np.isfinite(found).all():
        raise ModelUnfit(f"{words!r} should be three numbers")
    return found
