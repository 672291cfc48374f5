# SPDX-License-Identifier: BSD-3-Clause
"""collision.yaml: the shapes that must keep apart, and by how much."""

from __future__ import annotations

from dataclasses import dataclass

from rst_control.types import Point
from typed_config import flag, items, number, require_way, text


@dataclass(frozen=True, kw_only=True)
class BodyConfig:
    """A capsule: all points nearer than `radius` to the line from `start` to `end`."""

    name: str = text()
    link: str = text()
    start: Point = number(-0.9, 0.9, "m")
    end: Point = number(-0.9, 0.9, "m")
    radius: float = number(1e-4, 0.5, "m")


@dataclass(frozen=True, kw_only=True)
class LeftOutConfig:
    """A link, and others that it cannot meet."""

    link: str = text()
    others: tuple[str, ...] = text()


@dataclass(frozen=True, kw_only=True)
class CollisionConfig:
    """collision.yaml."""

    clearance: float = number(0.0, 0.2, "m")
    has_table: bool = flag()
    table_normal: Point = number(-1.0, 1.0, "")
    table_height: float = number(-3.0, 3.0, "m")
    bodies: tuple[BodyConfig, ...] = items(2, 64)
    left_out: tuple[LeftOutConfig, ...] = items(0, 200)

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require_way("table_normal", self.table_normal)
