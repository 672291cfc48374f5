# SPDX-License-Identifier: BSD-3-Clause
"""The robot's numbers as `config/gen3_openrst.yaml` holds them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rst_control.config import CONFIG_FOLDER
from rst_control.description.facts_config import (
    BodyFact,
    JointFact,
    LinkSettings,
    RobotSettings,
    Triple,
)
from typed_config import load_config, load_yaml

__all__ = ["FACTS_FILE", "JointFact", "LinkFact", "RobotFacts", "body_inertia", "load_facts"]

FACTS_FILE = CONFIG_FOLDER / "gen3_openrst.yaml"


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
        typed_config.ConfigError: A key is unknown, missing or not allowed; names it and the file.
    """
    data = load_yaml(path)
    settings = load_config(RobotSettings, data, path.name)
    return RobotFacts(
        name=settings.name,
        joints=settings.joints,
        links=tuple(_link(link) for link in settings.links),
        colours=settings.colours,
        visuals=tuple(data["visuals"]),
    )


def _link(link: LinkSettings) -> LinkFact:
    inertia = link.inertia or body_inertia(link.mass, _shape(link.body))
    return LinkFact(link.name, link.mass, link.com, inertia)


def _shape(body: BodyFact | None) -> Mapping[str, Any]:
    """The one shape that a body has, by its name."""
    return {key: value for key, value in vars(body).items() if value is not None}


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
