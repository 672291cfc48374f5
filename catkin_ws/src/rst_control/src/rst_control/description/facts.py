# SPDX-License-Identifier: BSD-3-Clause
"""gen3_openrst.yaml: the robot's numbers, from which the URDF is written.

What holds between joints and links is checked in the URDF (`urdf_checks`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from rst_control.config import CONFIG_FOLDER
from rst_control.types import Triple
from typed_config import choice, integer, items, load_file, number, require, text

FACTS_FILE = CONFIG_FOLDER / "gen3_openrst.yaml"
Six = tuple[float, float, float, float, float, float]
DENSITY = (100.0, 20_000.0)  # [kg/m^3] of a body: foam to tungsten
KEYS = {
    "cylinder": ("from", "to", "radius"),
    "sphere": ("at", "radius"),
    "box": ("at", "size"),
}  # of a visual, by its shape


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
    """A solid of even density: a box by its sides, or a cylinder along z."""

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

    def inertia(self, mass: float) -> Six:
        """ixx, ixy, ixz, iyy, iyz, izz about the centre [kg m^2] of a mass [kg]."""
        if self.box is not None:
            x, y, z = (side * side for side in self.box)
            return (mass * (y + z) / 12, 0.0, 0.0, mass * (x + z) / 12, 0.0, mass * (x + y) / 12)
        radius, length = self.cylinder or (0.0, 0.0)
        across = mass * (3 * radius**2 + length**2) / 12
        return (across, 0.0, 0.0, across, 0.0, mass * radius**2 / 2)


@dataclass(frozen=True, kw_only=True)
class LinkFact:
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
        if self.body is not None:
            low, high = (density * self.body.volume for density in DENSITY)
            allowed = f"{low:.3g} to {high:.3g} kg, by the size of its body"
            require(low <= self.mass <= high, "mass", self.mass, allowed)

    @property
    def moments(self) -> Six:
        """ixx, ixy, ixz, iyy, iyz, izz about the centre of mass [kg m^2]."""
        if self.body is not None:
            return self.body.inertia(self.mass)
        return self.inertia  # type: ignore[return-value]  # one of both is given


@dataclass(frozen=True, kw_only=True)
class VisualFact:
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
class RobotFacts:
    """The whole file."""

    name: str = text()
    joints: tuple[JointFact, ...] = items(1, 100)
    links: tuple[LinkFact, ...] = items(1, 100)
    colours: Mapping[str, tuple[float, float, float, float]] = number(0.0, 1.0, "")
    visuals: tuple[VisualFact, ...] = items(0, 1000)

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        links, colours = [link.name for link in self.links], self.colours
        for index, visual in enumerate(self.visuals):
            named = (("link", visual.link, links), ("colour", visual.colour, colours))
            for key, value, known in named:
                allowed = f"one of {', '.join(known)}"
                require(value in known, f"visuals[{index}].{key}", value, allowed)


def load_facts(path: Path = FACTS_FILE) -> RobotFacts:
    """Read the robot's numbers.

    Raises:
        typed_config.ConfigError: A key is unknown, missing or not allowed; names it and the file.
    """
    return load_file(RobotFacts, path)
