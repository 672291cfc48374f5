# SPDX-License-Identifier: BSD-3-Clause
"""Bounds that a URDF keeps before a model is made of it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree as Xml

import numpy as np

from rst_control.errors import RobotModelError

LARGEST = 5_000_000  # characters
FARTHEST = 2.0  # [m] of a joint from its parent
TURN = 6.2832  # [rad]
ORIGIN = (("xyz", FARTHEST, "m"), ("rpy", TURN, "rad"))
HEAVIEST = 100.0  # [kg] of a link
ROUNDING = 1e-6  # [-] of moments of inertia: a thin rod is at the bound
STRONGEST, FASTEST = 1000.0, 20.0  # [N m], [rad/s] of a joint
TYPES = ("fixed", "revolute", "continuous")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)


def read_joints(text: object) -> list[Xml.Element]:
    """Joints of a URDF text whose tree, numbers, axes, limits and masses make a robot.

    Raises:
        RobotModelError: They do not; names link or joint, value, and what was allowed.
    """
    robot = _parse(text)
    for link in robot.findall("link"):
        _check_link(link)
    joints = robot.findall("joint")
    for joint in joints:
        _check_joint(joint)
    _check_tree([_name(link, "link") for link in robot.findall("link")], joints)
    return joints


def _parse(text: object) -> Xml.Element:
    if not isinstance(text, str) or len(text) > LARGEST:
        raise _refusal("it", type(text).__name__, f"text of at most {LARGEST} characters")
    if "<!DOCTYPE" in text or "<!ENTITY" in text:  # a few entities can stand for gigabytes
        raise _refusal("it", "a document with <!DOCTYPE or <!ENTITY", "neither")
    try:
        robot = Xml.fromstring(text)
    except (Xml.ParseError, ValueError) as error:
        raise _refusal("it", f"no XML ({error})", "a whole XML document") from error
    if robot.tag != "robot":
        raise _refusal("its root", robot.tag, "robot")
    for element in robot.iter():
        if element.tag.startswith("{"):  # of a namespace, as xacro's before it was run
            raise _refusal("it", f"a document with {element.tag}", "URDF alone: run xacro first")
    return robot


def _check_link(link: Xml.Element) -> None:
    what = f"link {_name(link, 'link')}"
    for origin in link.iter("origin"):  # of its inertia and its shapes
        for key, most, unit in ORIGIN:
            if (text := origin.get(key)) is not None:
                _row(f"{what}: origin {key}", text, most, unit)
    inertial = link.find("inertial")
    if inertial is None:
        return  # a frame only
    mass = _number(f"{what}: mass", _attribute(what, inertial, "mass", "value"))
    if not 0.0 < mass <= HEAVIEST:
        raise _refusal(f"{what}: mass", mass, f"above 0, up to {HEAVIEST:g} kg")
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    words = [_attribute(what, inertial, "inertia", key) for key in keys]
    xx, xy, xz, yy, yz, zz = (_number(f"{what}: {k}", w) for k, w in zip(keys, words, strict=True))
    moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).tolist()  # rising
    if moments[0] <= 0.0 or moments[2] > (moments[0] + moments[1]) * (1.0 + ROUNDING):
        allowed = "each above 0, none above the sum of the others"
        raise _refusal(f"{what}: principal moments of inertia", moments, allowed)


def _check_joint(joint: Xml.Element) -> None:
    what = f"joint {_name(joint, 'joint')}"
    kind = joint.get("type")
    if kind not in TYPES:
        raise _refusal(f"{what}: type", kind, f"one of {', '.join(TYPES)}")
    if (mimic := joint.find("mimic")) is not None:
        raise _refusal(f"{what}: mimic", mimic.get("joint"), "no <mimic>: each joint by itself")
    for key, most, unit in ORIGIN:
        row = _attribute(what, joint, "origin", key)
        _row(f"{what}: origin {key}", row, most, unit)
    for key in ("parent", "child"):
        _attribute(what, joint, key, "link")
    limit = joint.find("limit")
    for key in ("lower", "upper"):
        if limit is not None and key in limit.attrib:
            _number(f"{what}: {key}", limit.attrib[key])
    if kind != "fixed":
        _check_motion(what, joint, kind)


def _check_motion(what: str, joint: Xml.Element, kind: str) -> None:
    axis = _attribute(what, joint, "axis", "xyz")
    if _row(f"{what}: axis", axis, 1.0, "") != (0.0, 0.0, 1.0):
        raise _refusal(f"{what}: axis", axis, "0 0 1")
    for key, most, unit in (("effort", STRONGEST, "N m"), ("velocity", FASTEST, "rad/s")):
        value = _number(f"{what}: {key}", _attribute(what, joint, "limit", key))
        if not 0.0 < value <= most:
            raise _refusal(f"{what}: {key}", value, f"above 0, up to {most:g} {unit}")
    if kind == "revolute":
        keys = ("lower", "upper")
        words = [_attribute(what, joint, "limit", key) for key in keys]
        low, high = (_number(f"{what}: {k}", w) for k, w in zip(keys, words, strict=True))
        if not -TURN <= low < high <= TURN:
            allowed = f"a rising pair within {TURN:g} rad"
            raise _refusal(f"{what}: lower, upper", [low, high], allowed)


def _check_tree(links: Sequence[str], joints: Sequence[Xml.Element]) -> None:
    names = [_name(joint, "joint") for joint in joints]
    parents = {_end(joint, "child"): _end(joint, "parent") for joint in joints}
    children = [_end(joint, "child") for joint in joints]
    for word, given in (("link", links), ("joint", names), ("child", children)):
        twice = sorted({name for name in given if list(given).count(name) > 1})
        if twice:
            raise _refusal(f"{word} {twice[0]}", "given twice", "each once")
    for joint in joints:
        for key in ("parent", "child"):
            if _end(joint, key) not in links:
                what = f"joint {_name(joint, 'joint')}: {key}"
                raise _refusal(what, _end(joint, key), f"one of {', '.join(links)}")
    roots = [name for name in links if name not in parents]
    if len(roots) != 1:
        raise _refusal("links that are no joint's child", roots, "one, the root")
    for link in links:
        passed = [link]
        while passed[-1] in parents:
            passed.append(parents[passed[-1]])
            if passed[-1] in passed[:-1]:
                raise _refusal("a way from child to parent", " - ".join(passed), "no circle")


def _name(element: Xml.Element, word: str) -> str:
    name = element.get("name", "").strip()
    if not name:
        raise _refusal(f"a {word}", "without a name", "a name for each")
    return name


def _end(joint: Xml.Element, key: str) -> str:
    return _attribute(f"joint {_name(joint, 'joint')}", joint, key, "link")


def _attribute(what: str, element: Xml.Element, child: str, key: str) -> str:
    found = element.findall(child)
    if len(found) != 1:
        raise _refusal(f"{what}: {child}", f"given {len(found)} times", f"one <{child} {key}=...>")
    value = found[0].get(key)
    if value is None:
        raise _refusal(f"{what}: {child} {key}", "missing", f"<{child} {key}=...>")
    return value


def _row(what: str, text: str, most: float, unit: str) -> tuple[float, ...]:
    values = tuple(_number(what, word) for word in text.split())
    if len(values) != 3 or max(abs(value) for value in values) > most:
        raise _refusal(what, text, f"three numbers from {-most:g} to {most:g} {unit}".rstrip())
    return values


def _number(what: str, text: str) -> float:
    if not _NUMBER.fullmatch(text.strip()) or abs(float(text)) > 1e9:
        raise _refusal(what, text, "a finite number up to 1e9")
    return float(text)


def _refusal(what: str, value: object, allowed: str) -> RobotModelError:
    shown = value if isinstance(value, str) else repr(value)
    return RobotModelError(f"URDF cannot be read: {what} is {shown:.200}, allowed: {allowed}")
