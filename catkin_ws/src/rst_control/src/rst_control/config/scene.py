# SPDX-License-Identifier: BSD-3-Clause
"""scene.yaml: where trocar, robot and tissue are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from rst_control.types import PLAN_COUNT, Point
from typed_config import choice, integer, number, require, require_rising, require_way

MIN_ANGLE = 0.02  # [rad] between two directions of a sheet
MAX_COSINE = 0.7  # of jaw_axis and approach_axis: what is not square is made so, within 45 deg


@dataclass(frozen=True, kw_only=True)
class TissueConfig:
    """A sheet fixed at its rim."""

    centre: Point = number(-2.0, 2.0, "m")
    along: Point = number(-1.0, 1.0, "")
    across: Point = number(-1.0, 1.0, "")
    size: tuple[float, float] = number(0.01, 0.5, "m")
    nodes: tuple[int, int] = integer(3, 101)
    rim: tuple[str, ...] = choice("start", "end", "left", "right")
    stiffness: float = number(20.0, 1000.0, "N/m")
    reference_point: Point = number(-2.0, 2.0, "m")
    reference_pull: Point = number(-0.1, 0.1, "m")
    density: float = number(0.1, 20.0, "kg/m^2")
    damping_ratio: float = number(0.0, 5.0, "")
    bed_stiffness: float = number(0.0, 500.0, "N/m")
    grasp_radius: float = number(1e-4, 0.02, "m")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        for name in ("along", "across", "reference_pull"):
            require_way(name, getattr(self, name))
        normal = np.cross(self.along, self.across)
        sides = np.linalg.norm(self.along) * np.linalg.norm(self.across)
        require(
            bool(np.linalg.norm(normal) > MIN_ANGLE * sides),
            "across",
            list(self.across),
            f"another direction than along, {list(self.along)}",
        )
        require(bool(self.rim), "rim", list(self.rim), "at least one of start, end, left, right")


@dataclass(frozen=True, kw_only=True)
class TriangulationConfig:
    """What a triangulated sheet keeps."""

    RENAMED: ClassVar[Mapping[str, str]] = {"least_angle": "min_angle"}

    grasp_error: float = number(1e-5, 0.01, "m")
    min_angle: float = number(0.0, 1.0, "rad")
    out_of_plane: float = number(1e-5, 0.02, "m")
    tension: tuple[float, float] = number(0.0, 2.4, "N")
    strain: float = number(0.01, 5.0, "")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require_rising("tension", self.tension)


@dataclass(frozen=True, kw_only=True)
class SceneConfig:
    """scene.yaml: where trocar, robot and tissue are; read by controller and simulator."""

    trocar: Point = number(-2.0, 2.0, "m")
    home: tuple[float, ...] = number(-6.3, 6.3, "rad")
    home_opening: float = number(0.0, 1.5, "rad")
    workspace_centre: Point = number(-2.0, 2.0, "m")
    workspace_radius: float = number(0.005, 0.3, "m")
    grasp_point: Point = number(-2.0, 2.0, "m")
    approach_axis: tuple[float, ...] = number(-1.0, 1.0, "")
    jaw_axis: tuple[float, ...] = number(-1.0, 1.0, "")
    clearance: float = number(0.001, 0.05, "m")
    pull_direction: tuple[float, ...] = number(-1.0, 1.0, "")
    max_displacement: float = number(0.001, 0.1, "m")
    gravity: tuple[float, ...] = number(-1.0, 1.0, "")
    outward: Point = number(-1.0, 1.0, "")
    surface_margin: float = number(0.001, 0.1, "m")
    standoff: float = number(0.005, 0.3, "m")
    tissue: TissueConfig
    triangulation: TriangulationConfig

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        allowed = f"a list of {PLAN_COUNT} angles [rad]"
        require(len(self.home) == PLAN_COUNT, "home", list(self.home), allowed)
        require_way("outward", self.outward)
        for name in ("approach_axis", "jaw_axis", "pull_direction", "gravity"):
            way = getattr(self, name)
            is_way = len(way) in (0, 3) and (not way or any(way))
            require(is_way, name, list(way), "[] or three numbers, not all 0")
        if self.approach_axis and self.jaw_axis:
            lengths = np.linalg.norm(self.approach_axis) * np.linalg.norm(self.jaw_axis)
            cosine = np.dot(self.approach_axis, self.jaw_axis) / lengths
            allowed = f"square to approach_axis, {list(self.approach_axis)}"
            require(bool(abs(cosine) < MAX_COSINE), "jaw_axis", list(self.jaw_axis), allowed)
