# SPDX-License-Identifier: BSD-3-Clause
"""Reads the URDF into the chain of fixed transforms that the compiled kinematics take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
from numpy.typing import NDArray

from rst_control.config import URDF_FILE
from rst_control.description.urdf_checks import read_joints
from rst_control.errors import RobotModelError
from rst_control.kinematics.forward import LOCKS, PITCH, SHAFT, TIP
from rst_control.types import ARM_JOINTS, JOINTS

Array = NDArray[np.float64]
MOVING = (*ARM_JOINTS, "joint_pitch", "joint_finger_left")  # whose values are q, yaw the last
STRAIGHT = 1e-6  # [m] that the pitch joint may be beside the shaft
ASIDE = 1e-4  # [m] that the tip may be beside the shaft, and one finger's joint from the other's
ASKEW = 1e-3  # [rad] between directions of the tool that have to be the same
FRAMES = ("interface_link", "tool0", "tool_tip")  # in the order of `forward.SHAFT` and so on


@dataclass(frozen=True, eq=False)
class Link:
    """How one link hangs on its parent."""

    joint: str
    type: str
    parent: str
    xyz: tuple[float, float, float]  # [m]
    rpy: tuple[float, float, float]  # [rad], fixed axes
    lower: float  # [rad]
    upper: float  # [rad]

    @property
    def T_parent_link(self) -> Array:
        """Pose of the link in its parent at joint angle zero. Shape (4, 4)."""
        T = np.eye(4)
        T[:3, :3] = rotation(self.rpy)
        T[:3, 3] = self.xyz
        return T


@dataclass(frozen=True, eq=False)
class RobotModel:
    """The robot as its URDF describes it."""

    links: dict[str, Link]  # by the name of the link
    chain: Array  # (13, 3, 4), see forward.py, read-only

    @cached_property
    def locked(self) -> tuple[int, ...]:
        """Numbers in q of the arm's joints that it does not have: fixed in the URDF."""
        return tuple(int(k) for k in np.flatnonzero(self.chain[LOCKS].ravel()))

    @cached_property
    def shaft_length(self) -> float:
        """Length of the straight shaft, from interface_link to the pitch joint [m]."""
        shaft, wrist = self.chain[SHAFT], self.chain[PITCH, :, 3]
        return float(shaft[:, 2] @ (wrist - shaft[:, 3]))

    @cached_property
    def wrist_length(self) -> float:
        """From the pitch joint to the tip of a straight tool [m]."""
        finger, tip = self.chain[PITCH + 1], self.chain[TIP]
        return float(np.linalg.norm(finger[:, :3] @ tip[:, 3] + finger[:, 3]))

    @cached_property
    def link_of(self) -> dict[str, str]:
        """Name of the link that each joint carries, by the joint's."""
        return {link.joint: name for name, link in self.links.items()}

    @cached_property
    def standing(self) -> tuple[str, ...]:
        """Links that at most turn on the spot: base_link, and the one behind the first joint."""
        first = next(n for n in range(len(MOVING)) if n not in self.locked)
        return "base_link", self.link_of[MOVING[first]]

    @cached_property
    def insertable(self) -> tuple[str, ...]:
        """Links of the tool that fit the trocar; the right jaw counts with the left."""
        return FRAMES[0], self.link_of["joint_pitch"], self.link_of["joint_finger_left"]

    @cached_property
    def T_root_base(self) -> Array:
        """Pose of base_link in the URDF's root; joints between count as at zero. Shape (4, 4)."""
        T, link = np.eye(4), "base_link"
        while link in self.links:
            T = self.links[link].T_parent_link @ T
            link = self.links[link].parent
        return T

    def route(self, tip: str) -> tuple[str, ...]:
        """Links from the base, which is left out, to the tip.

        Raises:
            RobotModelError: There is no such link.
        """
        route: list[str] = []
        while tip != "base_link":
            if tip not in self.links:
                raise RobotModelError(f"no link {tip!r}, allowed: {', '.join(self.links)}")
            route.append(tip)
            tip = self.links[tip].parent
        return tuple(reversed(route))


@lru_cache(maxsize=4)
def load_robot(path: Path = URDF_FILE) -> RobotModel:
    """Read a URDF file; cached, since the result never changes.

    Raises:
        RobotModelError: It is not this robot's.
        OSError: The file cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise RobotModelError(f"URDF {path.name} is not UTF-8: {error}, allowed: text") from error
    return parse_robot(text)


def parse_robot(text: str) -> RobotModel:
    """Read a URDF text, such as the parameter `robot_description`.

    Raises:
        RobotModelError: It is not this robot's.
    """
    links = dict(_read_link(joint) for joint in read_joints(text))
    model = RobotModel(links, np.zeros((13, 3, 4)))
    model.chain[:] = _compile(model)
    model.chain.flags.writeable = False
    return model


def rotation(rpy: Sequence[float]) -> Array:
    """Rotation matrix of roll, pitch and yaw about fixed axes [rad]. Shape (3, 3)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _read_link(joint: Xml.Element) -> tuple[str, Link]:
    """Name of the child, and how it hangs on its parent; the joint was checked."""
    parts = {part.tag: part.attrib for part in joint}
    bounds = parts.get("limit", {})
    link = Link(
        joint=joint.attrib["name"],
        type=joint.attrib["type"],
        parent=parts["parent"]["link"],
        xyz=_triple(parts["origin"]["xyz"]),
        rpy=_triple(parts["origin"]["rpy"]),
        lower=float(bounds.get("lower", "-inf")),
        upper=float(bounds.get("upper", "inf")),
    )
    return parts["child"]["link"], link


def _triple(text: str) -> tuple[float, float, float]:
    x, y, z = (float(word) for word in text.split())
    return x, y, z


def _compile(model: RobotModel) -> Array:
    missing = [name for name in JOINTS if name not in model.link_of]
    missing += [name for name in FRAMES if name not in model.links]
    if missing:
        raise RobotModelError(f"URDF without {', '.join(missing)}")
    _check_order(model)
    targets = [model.link_of[name] for name in MOVING] + list(FRAMES)
    chain = np.zeros((13, 3, 4))
    chain[:LOCKS] = [behind_joint(model, name)[:3] for name in targets]
    kinds = [model.links[model.link_of[name]].type for name in MOVING]
    chain[LOCKS].flat[: len(MOVING)] = [kind == "fixed" for kind in kinds]
    _check_shaft(chain)
    _check_tip(chain)
    _check_fingers(model)
    return chain


def _check_order(model: RobotModel) -> None:
    """An arm that lacks joints says so: a fixed one, with a link of that name, is in its place."""
    there = [
        link.joint
        for name, link in ((name, model.links[name]) for name in model.route("tool_tip"))
        if link.type != "fixed" or (link.joint in ARM_JOINTS and name == f"locked_{link.joint}")
    ]
    if tuple(there) != MOVING:
        raise RobotModelError(f"joints up to tool_tip are not {', '.join(MOVING)}")


def _check_shaft(chain: Array) -> None:
    shaft, wrist = chain[SHAFT], chain[PITCH, :, 3]
    x, y, along = shaft[:, :3].T @ (wrist - shaft[:, 3])
    if max(abs(x), abs(y)) > STRAIGHT or along <= 0.0:
        raise RobotModelError(
            f"pitch joint at {x * 1e3:.3f}, {y * 1e3:.3f}, {along * 1e3:.3f} mm of interface_link, "
            "allowed: on its z axis, in front of it"
        )


def _check_tip(chain: Array) -> None:
    """With pitch and yaw at zero the tool is straight, and its jaws point and open as planned."""
    shaft, wrist, finger, tip = (_square(chain[k]) for k in (SHAFT, PITCH, PITCH + 1, TIP))
    T = np.linalg.inv(shaft) @ wrist @ finger @ tip  # of tool_tip in interface_link
    x, y, along = T[:3, 3]
    length = float(chain[SHAFT, :, 2] @ (wrist - shaft)[:3, 3])
    if np.hypot(x, y) > ASIDE or along <= length:
        raise RobotModelError(
            f"URDF at pitch and yaw zero: tool_tip at {x * 1e3:.3f}, {y * 1e3:.3f}, "
            f"{along * 1e3:.3f} mm of interface_link, allowed: up to {ASIDE * 1e3:g} mm beside its "
            f"z axis, and above {length * 1e3:.3f} mm along it, beyond the pitch joint"
        )
    _check_direction("-y of tool_tip in interface_link", -T[:3, 1], 1.0)
    _check_direction("z of tool_tip in the left finger's link", tip[:3, 2], 1.0)


def _check_fingers(model: RobotModel) -> None:
    left, right = (model.links[model.link_of[name]] for name in JOINTS[8:])
    if right.type == "fixed":
        raise RobotModelError("URDF: joint_finger_right is fixed, allowed: revolute or continuous")
    apart = float(np.linalg.norm(np.subtract(right.xyz, left.xyz)))
    if right.parent != left.parent or apart > ASIDE:
        raise RobotModelError(
            f"URDF: joint_finger_right at {list(right.xyz)} m of {right.parent}, allowed: the "
            f"left one's place within {ASIDE * 1e3:g} mm, {list(left.xyz)} m of {left.parent}"
        )
    axis = rotation(left.rpy).T @ rotation(right.rpy)[:, 2]
    _check_direction("axis of joint_finger_right in the left finger's link", axis, -1.0)


def _check_direction(what: str, axis: Array, z: float) -> None:
    """Whether a unit vector (3,) is (0, 0, z)."""
    angle = float(np.arctan2(np.hypot(*axis[:2]), z * axis[2]))
    if angle > ASKEW:
        raise RobotModelError(
            f"URDF at pitch and yaw zero: {what} is ({axis[0]:.4f}, {axis[1]:.4f}, {axis[2]:.4f}), "
            f"{angle:.4f} rad off, allowed: (0, 0, {z:g}) within {ASKEW:g} rad"
        )


def behind_joint(model: RobotModel, name: str) -> Array:
    """Pose (4, 4) of a link in the last link before it that a joint of MOVING carries."""
    link = model.links[name]
    T = link.T_parent_link
    while link.parent != "base_link" and model.links[link.parent].joint not in MOVING:
        link = model.links[link.parent]
        T = link.T_parent_link @ T
    return T


def _square(pose: Array) -> Array:
    return np.vstack([pose, [0.0, 0.0, 0.0, 1.0]])
