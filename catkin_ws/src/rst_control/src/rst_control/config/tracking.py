# SPDX-License-Identifier: BSD-3-Clause
"""controller.yaml, `tracking`: places that a tracker reports, and what is not believed of them."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import choice, flag, number, text
from typed_config.node_names import require_names


@dataclass(frozen=True, kw_only=True)
class TrackedGraspConfig:
    """When a reported grasp point is taken by itself."""

    is_taken: bool = flag()
    steady_time: float = number(0.05, 10.0, "s")
    steady_within: float = number(1e-5, 0.01, "m")
    min_change: float = number(1e-4, 0.05, "m")
    range: float = number(0.001, 0.2, "m")


@dataclass(frozen=True, kw_only=True)
class TrackedTrocarConfig:
    """How a reported trocar is followed."""

    motion: str = choice("fixed", "followed")
    range: float = number(0.0005, 0.03, "m")
    max_speed: float = number(0.001, 0.1, "m/s")
    max_acceleration: float = number(0.01, 5.0, "m/s^2")
    jump: float = number(1e-4, 0.01, "m")
    filter_time: float = number(0.01, 2.0, "s")


@dataclass(frozen=True, kw_only=True)
class TrackingConfig:
    """Places that a tracker reports."""

    tracker: tuple[str, ...] = text()
    frames: tuple[str, ...] = text()
    age: float = number(0.01, 2.0, "s")
    frame_age: float = number(0.01, 10.0, "s")
    grasp_point: TrackedGraspConfig
    trocar: TrackedTrocarConfig

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require_names("tracker", self.tracker)
        require_names("frames", self.frames)
