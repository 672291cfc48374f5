# SPDX-License-Identifier: BSD-3-Clause
"""gen3_openrst.yaml: the robot's numbers, from which the URDF is written."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from typed_config import choice, integer, items, number, require, text

Triple = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]
DENSITY = (100.0, 20_000.0)  # [kg/m^3] of a body: foam to tungsten
ENDS, PLACE = ("from", "to", "radius"), ("at",)
KEYS = {"cylinder": ENDS, "sphere": (*PLACE, "radius"), "box": (*PLACE, "size")}


@dataclass(frozen=True, kw_only=True)
class JointFact:
    """One joint; its axis is the child's z axis."""

    name: str = text()
    type: str = choice("fixed", "revolute", "continuous")
    parent: str = text()
    child: str = text()
    xyz: Triple = number(-1.0, 1.0, "m")
    quarter_turns: tuple[int, int, int] = integer(-3, 3, "quarter turns")  # about x, y, z of parent
    lower: float = number(-6.2832, 0.0, "rad")
    upper: float = number(0.0, 6.2832, "rad")
    effort: float = number(0.0, 200.0, "N m")
    velocity: float = number(0.0, 20.0, "rad/s")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        has_range = self.type == "revolute"
        allowed = f"above lower, {self.lower:g} rad" if has_range else f"0 where it is {self.type}"
        is_right = self.upper > self.lower if has_range else self.upper == self.lower == 0.0
        require(is_right, "upper", self.upper, allowed)
        for key in ("effort", "velocity"):
            value = getattr(self, key)
            is_fixed = self.type == "fixed"
            allowed = "0 of a joint that is fixed" if is_fixed else "above 0 of a joint that moves"
            require((value == 0.0) == is_fixed, key, value, allowed)


@dataclass(frozen=True, kw_only=True)
class BodyFact:
    """A solid of even density, whose inertia a link takes."""

    box: Triple | None = number(1e-4, 0.9, "m", default=None)  # sides
    cylinder: tuple[float, float] | None = number(1e-4, 0.9, "m", default=None)  # radius, length

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        given = [key for key in ("box", "cylinder") if getattr(self, key) is not None]
        require(len(given) == 1, "shape", given, "one of box, cylinder")

    @property
    def volume(self) -> float:
        """[m^3]."""
        if self.box is not None:
            return math.prod(self.box)
        radius, length = self.cylinder or (0.0, 0.0)  # one of them is given
        return math.pi * radius**2 * length


@dataclass(frozen=True, kw_only=True)
class LinkSettings:
    """Mass of one link, and its inertia or the body that has it."""

    name: str = text()
    mass: float = number(1e-6, 50.0, "kg")
    com: Triple = number(-0.9, 0.9, "m")
    inertia: Six | None = number(-1.0, 1.0, "kg m^2", default=None)
    body: BodyFact | None = None

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        given = [key for key in ("inertia", "body") if getattr(self, key) is not None]
        require(len(given) == 1, "inertia", given, "one of inertia, body")
        if self.inertia is not None:
            ixx, _, _, iyy, _, izz = self.inertia
            allowed = "ixx, iyy and izz above 0, none above the sum of the others"
            largest = max(ixx, iyy, izz)
            is_body = min(ixx, iyy, izz) > 0.0 and 2.0 * largest <= ixx + iyy + izz
            require(is_body, "inertia", list(self.inertia), allowed)
        if self.body is not None:
            low, high = (density * self.body.volume for density in DENSITY)
            allowed = f"{low:.3g} to {high:.3g} kg, by the size of its body"
            require(low <= self.mass <= high, "mass", self.mass, allowed)


@dataclass(frozen=True, kw_only=True)
class VisualSettings:
    """One shape that is drawn of a link."""

    link: str = text()
    shape: str = choice("cylinder", "sphere", "box")
    colour: str = text()
    from_: Triple | None = number(-0.9, 0.9, "m", default=None)
    to: Triple | None = number(-0.9, 0.9, "m", default=None)
    at: Triple | None = number(-0.9, 0.9, "m", default=None)
    size: Triple | None = number(1e-4, 0.9, "m", default=None)
    radius: float | None = number(1e-4, 0.5, "m", default=None)

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        wanted = KEYS[self.shape]
        names = {"from": self.from_, "to": self.to, "at": self.at, "size": self.size}
        given = [key for key, value in (names | {"radius": self.radius}).items() if value]
        allowed = f"{', '.join(wanted)} and no other"
        require(sorted(given) == sorted(wanted), self.shape, given, allowed)
        if self.shape == "cylinder":
            require(self.from_ != self.to, "to", self.to, f"not the same as from, {self.from_}")


@dataclass(frozen=True, kw_only=True)
class RobotSettings:
    """The whole file."""

    name: str = text()
    joints: tuple[JointFact, ...] = items(1, 100)
    links: tuple[LinkSettings, ...] = items(1, 100)
    colours: Mapping[str, tuple[float, float, float, float]] = number(0.0, 1.0, "")
    visuals: tuple[VisualSettings, ...] = items(0, 1000)

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        links, children = [e.name for e in self.links], [j.child for j in self.joints]
        self._require_unlike("links", links)
        self._require_unlike("joints", [j.name for j in self.joints])
        self._require_unlike("joints", children)
        roots = {j.parent for j in self.joints} - set(children)
        require(len(roots) == 1, "joints", sorted(roots), "one link that is no child: no cycle")
        self._require_tree()
        allowed = f"one of {', '.join(links)}"
        for index, child in enumerate(children):
            require(child in links, f"joints[{index}].child", child, allowed)
        for index, link in enumerate(links):
            require(link in children, f"links[{index}].name", link, "child of a joint")
        for index, visual in enumerate(self.visuals):
            require(visual.link in links, f"visuals[{index}].link", visual.link, allowed)
            names = f"one of {', '.join(self.colours)}"
            is_known = visual.colour in self.colours
            require(is_known, f"visuals[{index}].colour", visual.colour, names)

    def _require_tree(self) -> None:
        parents = {joint.child: joint.parent for joint in self.joints}
        for index, joint in enumerate(self.joints):
            passed, link = [joint.child], joint.parent
            while link in parents and link not in passed:
                passed.append(link)
                link = parents[link]
            allowed = "no link that hangs on this joint's own child"
            require(link not in passed, f"joints[{index}].parent", joint.parent, allowed)

    @staticmethod
    def _require_unlike(key: str, names: list[str]) -> None:
        require(len(set(names)) == len(names), key, names, "names that differ")
