# SPDX-License-Identifier: BSD-3-Clause
"""Chooses how to take a sheet of tissue: the best way whose reach, pull and retreat are free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from rst_control.errors import Infeasible, NoGrasp
from rst_control.planning.planner import Planner
from rst_control.tissue.grasp_candidates import GraspWay
from rst_control.trajectory.path import Path
from rst_control.types import Vector

MAX_PLANNED: Final = 12  # ways whose paths are planned, the best first
TOLD: Final = 3  # reasons in a refusal
ENOUGH_MARGIN: Final = 0.15  # share of a joint's half range; more to its limit is no better
MARGIN_WEIGHT: Final = 4.0  # [rad] askew that a way may be, to win a whole half range of margin


@dataclass(frozen=True, eq=False)
class GraspPlan:
    """How the sheet is taken and pulled, every path checked."""

    way: GraspWay
    reach: tuple[Path, ...]  # to the grasp, in order; empty where the jaws are there
    pull: Path
    retreat: Path  # from the grasp, out of the tissue


def choose_grasp(planner: Planner, q: Vector) -> GraspPlan:
    """Plan the grasp from q (9,) [rad]; the same q always gives the same.

    Ways are ranked by how square the jaws stand to the sheet and by the joints' margin to their
    limits; the first is taken from which everything up to the retreat keeps all limits.

    Raises:
        Infeasible: No way keeps all limits; where there was a choice it is a `NoGrasp`.
    """
    if len(planner.ways) == 1:
        return _plan(planner, q, planner.ways[0])
    reasons: list[Infeasible] = []
    for way in _ranked(planner, q)[:MAX_PLANNED]:
        try:
            return _plan(planner, q, way)
        except Infeasible as reason:
            reasons.append(reason)
    raise NoGrasp(tuple(reasons[:TOLD]), len(planner.ways))


def _plan(planner: Planner, q: Vector, way: GraspWay) -> GraspPlan:
    reach = planner.reach(q, way)
    at_grasp = reach[-1].end if reach else q
    return GraspPlan(way, reach, planner.pull(at_grasp), planner.retreat(at_grasp))


def _ranked(planner: Planner, q: Vector) -> list[GraspWay]:
    """All ways, the best first; those at which the joints cannot hold the tool come last."""
    costs = []
    for way in planner.ways:
        posture = planner.solver.settle(q, way.T_base_tip, planner.trocar)
        lacking = max(0.0, ENOUGH_MARGIN - _margin(planner, posture.q))
        costs.append((not posture.is_solved, round(way.askew + MARGIN_WEIGHT * lacking, 9)))
    order = sorted(range(len(costs)), key=costs.__getitem__)
    return [planner.ways[i] for i in order]


def _margin(planner: Planner, q: Vector) -> float:
    """Least distance of a joint from its limits, as a share of half its range."""
    limits = planner.limits
    room = np.minimum(q - limits.lower, limits.upper - q)
    return float((2.0 * room / (limits.upper - limits.lower)).min())
