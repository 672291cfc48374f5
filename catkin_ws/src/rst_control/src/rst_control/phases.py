# SPDX-License-Identifier: BSD-3-Clause
"""Phases along a path, taken as fast as the joints can follow and still brake in time."""

from __future__ import annotations

from rst_control.path import Path
from rst_control.planner import Planner
from rst_control.types import Phase, PhaseKind


def along(planner: Planner, kind: PhaseKind, path: Path, speed: float) -> Phase:
    """Phase from one end of a path to the other, at up to `speed` [m/s]."""
    pace = planner.pace(path, speed)
    return Phase(
        kind,
        path,
        target=path.length,
        speed=pace.moving.speed,
        acceleration=pace.moving.acceleration,
        braking=pace.braking.acceleration,
    )
