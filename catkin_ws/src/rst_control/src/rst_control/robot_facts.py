# SPDX-License-Identifier: BSD-3-Clause
"""The robot's numbers as `config/gen3_openrst.yaml` holds them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rst_control.config import CONFIG_FOLDER
from typed_config import load_yaml

FACTS_FILE = CONFIG_FOLDER / "gen3_openrst.yaml"
Triple = tuple[float, float, float]


@dataclass(frozen=True)
class JointFact:
    """One joint; its axis is the child's z axis."""

    name: str
    type: str
    parent: str
    child: str
    xyz: Triple  # [m]
    quarter_turns: tuple[int, int, int]  # about x, y, z of the parent
    lower: float  # [rad]
    upper: float  # [rad]
    effort: float  # [N m]
    velocity: float  # [rad/s]


@dataclass(frozen=True)
class LinkFact:
    """Mass of one link and how it is spread about the centre of mass."""

    name: str
    mass: float  # [kg]
    com: Triple  # [m]
    inertia: tuple[float, ...]  # ixx, ixy, ixz, iyy, iyz, izz [kg m^2]


@dataclass(frozen=True)
class RobotFacts:
    """Everything the URDF is written from."""

    name: str
    joints: tuple[JointFact, ...]
    links: tuple[LinkFact, ...]
    colours: Mapping[str, tuple[float, ...]]
    visuals: tuple[Mapping[str, Any], ...]


def load_facts(path: Path = FACTS_FILE) -> RobotFacts:
    """Read the robot's numbers.

    Raises:
        typed_config.ConfigError: The file cannot be read.
        KeyError: A number is missing.
    """
    data = load_yaml(path)
    return RobotFacts(
        name=data["name"],
        joints=tuple(_joint(entry) for entry in data["joints"]),
        links=tuple(_link(entry) for entry in data["links"]),
        colours=data["colours"],
        visuals=tuple(data["visuals"]),
    )


def _joint(entry: Mapping[str, Any]) -> JointFact:
    tuples = {key: tuple(entry[key]) for key in ("xyz", "quarter_turns")}
    return JointFact(**{**entry, **tuples})


def _link(entry: Mapping[str, Any]) -> LinkFact:
    inertia = entry.get("inertia") or body_inertia(entry["mass"], entry["body"])
    return LinkFact(entry["name"], entry["mass"], tuple(entry["com"]), tuple(inertia))


def body_inertia(mass: float, body: Mapping[str, Any]) -> tuple[float, ...]:
    """Inertia of a solid box (sides) or cylinder (radius, length along z) about its centre.

    Args:
        mass: [kg].
        body: `{"box": [x, y, z]}` or `{"cylinder": [radius, length]}`, [m].

    Returns:
        ixx, ixy, ixz, iyy, iyz, izz [kg m^2].
    """
    if "box" in body:
        x, y, z = (side * side for side in body["box"])
        return (mass * (y + z) / 12, 0.0, 0.0, mass * (x + z) / 12, 0.0, mass * (x + y) / 12)
    radius, length = body["cylinder"]
    across = mass * (3 * radius**2 + length**2) / 12
    return (across, 0.0, 0.0, across, 0.0, mass * radius**2 / 2)
