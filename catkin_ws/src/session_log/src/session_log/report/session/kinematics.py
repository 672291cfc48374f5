# SPDX-License-Identifier: BSD-3-Clause
"""Poses of a link from joint positions, along the URDF that the recording holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
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


def poses(
    urdf: str, base: str, link: str, q: Mapping[str, Track], columns: Sequence[int] = range(4)
) -> Array:
    """Poses of `link` in `base` for joint positions over time.

    Args:
        urdf: Text of the robot model.
        base: Name of the link in whose frame the poses are.
        link: Name of the link; below `base` in the tree.
        q: Position of each joint that moves, by name, [rad] or [m]. Each of shape (n,).
        columns: Which of a pose are wanted, from 0 to 3: the axes and the position.

    Returns:
        Columns of homogeneous transforms. Shape (n, 4, number of columns).

    Raises:
        ModelUnfit: The URDF cannot be read, has no such link, or moves by an unknown joint.
    """
    chain = _chain(urdf, base, link)
    for joint in chain:
        if joint.kind != "fixed" and joint.name not in q:
            raise ModelUnfit(f"joint {joint.name} is not among the recorded joints")
    count = len(next(iter(q.values()), ()))
    found = np.repeat(np.eye(4)[:, list(columns), None], count, axis=2)  # (4, columns, n)
    for joint in reversed(chain):
        found = _carried(joint, q, found)
    return np.moveaxis(found, -1, 0)


@dataclass(frozen=True, eq=False)
class _Joint:
    """One joint of a chain."""

    name: str
    kind: str
    origin: Array  # (4, 4), of the joint in its parent
    axis: Array  # (4,), of length one; zero of a fixed joint
    turn: Array  # (4, 4), cross product of the axis with a column


@lru_cache(maxsize=8)  # asked for each thousand joint states
def _chain(urdf: str, base: str, link: str) -> tuple[_Joint, ...]:
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
    return tuple(map(_joint, found[::-1]))


def _end(joint: Element, which: str) -> str:
    end = joint.find(which)
    return "" if end is None else end.get("link", "")


def _joint(element: Element) -> _Joint:
    kind, name = element.get("type", ""), element.get("name", "")
    origin, axis = np.eye(4), np.zeros(4)
    if (place := element.find("origin")) is not None:
        origin[:3, 3] = _numbers(place.get("xyz", "0 0 0"))
        rpy = _numbers(place.get("rpy", "0 0 0"))
        origin[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
    if kind != "fixed":
        if kind not in TURNING + SLIDING:
            raise ModelUnfit(
                f"joint {name} is {kind}, not fixed, revolute, continuous or prismatic"
            )
        way = element.find("axis")
        axis[:3] = _numbers("1 0 0" if way is None else way.get("xyz", "1 0 0"))
        axis /= np.linalg.norm(axis)
    turn = np.zeros((4, 4))
    turn[:3, :3] = np.cross(np.eye(3), axis[:3])
    return _Joint(name, kind, origin, axis, turn)


def _carried(joint: _Joint, q: Mapping[str, Track], columns: Array) -> Array:
    """What a joint moves, seen from its parent. Both of shape (4, columns, n)."""
    if joint.kind in TURNING:  # by Rodrigues' formula, with the same matrices for all times
        once = np.tensordot(joint.turn, columns, 1)
        twice = np.tensordot(joint.turn, once, 1)
        angle = q[joint.name]
        columns = columns + np.sin(angle) * once + (1.0 - np.cos(angle)) * twice
    elif joint.kind in SLIDING:
        columns = columns + joint.axis[:, None, None] * (q[joint.name] * columns[3])
    return np.tensordot(joint.origin, columns, 1)


def _numbers(words: str) -> Array:
    try:
        found = np.array([float(word) for word in words.split()])
    except ValueError as error:
        raise ModelUnfit(f"{words!r} should be three numbers") from error
    if found.shape != (3,) or not np.isfinite(found).all():
        raise ModelUnfit(f"{words!r} should be three numbers")
    return found
