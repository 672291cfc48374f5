# SPDX-License-Identifier: BSD-3-Clause
"""The way of the tool tip under a plan: what of it is travelled, and what lies ahead."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.planning.plan import Phase
from rst_control.trajectory.path import Path
from rst_control.visualization.shapes import Points

PER_KNOT = 2  # samples of a path between two knots; their tips are joined by straight lines

TipsOfPath = Callable[[Path], tuple[Points, Points]]  # s (n,) and tips (n, 3) of a path, [m]


@dataclass(frozen=True, eq=False)
class RoutePart:
    """A part of a path."""

    path: Path
    start: float  # [m] of s
    end: float  # [m] of s


@dataclass(frozen=True, eq=False)
class Route:
    """Parts of paths, in the order in which the tip takes them."""

    travelled: tuple[RoutePart, ...] = ()
    ahead: tuple[RoutePart, ...] = ()


def route(view: ControllerSnapshot) -> Route:
    """Way of the plan under way; at rest with tissue held, that of the pull; else none."""
    if view.motion is not None and view.plan is not None:
        return _of_phases(view, view.plan.phases)
    if view.grasp is not None:
        pull, s = view.grasp.pull, view.grasp.s
        return Route((RoutePart(pull, 0.0, s),), (RoutePart(pull, s, pull.length),))
    return Route()


def tips(part: RoutePart, tips_of_path: TipsOfPath) -> Points:
    """Places of the tip along a part of a path, base frame, [m]. Shape (n, 3)."""
    s, places = tips_of_path(part.path)
    low, high = sorted((part.start, part.end))
    wanted = np.concatenate([[low], s[(s > low) & (s < high)], [high]])
    if part.end < part.start:
        wanted = wanted[::-1]
    return np.column_stack([np.interp(wanted, s, places[:, k]) for k in range(3)])


def _of_phases(view: ControllerSnapshot, phases: tuple[Phase, ...]) -> Route:
    present = _present(view, phases)
    travelled, ahead = [], []
    for k, phase in enumerate(phases):
        if phase.path is None:
            continue
        s = phase.target if k < present else phase.start
        if k == present and view.path is phase.path:
            s = view.path_position
        if s != phase.start:
            travelled.append(RoutePart(phase.path, phase.start, s))
        if s != phase.target:
            ahead.append(RoutePart(phase.path, s, phase.target))
    return Route(tuple(travelled), tuple(ahead))


def _present(view: ControllerSnapshot, phases: tuple[Phase, ...]) -> int:
    """Which phase is under way; two of a kind differ by their paths."""
    kind = view.motion.phase if view.motion else None
    same = [k for k, phase in enumerate(phases) if phase.kind is kind]
    here = [k for k in same if phases[k].path is view.path]
    return (here or same or [0])[0]
