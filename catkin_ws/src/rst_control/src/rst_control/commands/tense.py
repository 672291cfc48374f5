# SPDX-License-Identifier: BSD-3-Clause
"""Chooses a grasp of the sheet: the best candidate whose reach, pull and retreat are free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from rst_control.errors import Infeasible, NoGrasp
from rst_control.planning.planner import Planner
from rst_control.tissue.grasp_candidates import GraspCandidate
from rst_control.trajectory.path import Path
from rst_control.types import Vector

MAX_PLANNED: Final = 12  # candidates whose paths are planned, the best first
TOLD: Final = 3  # reasons in a refusal
ENOUGH_MARGIN: Final = 0.15  # share of a joint's half range; more to its limit is no better
MARGIN_WEIGHT: Final = (
    4.0  # [rad] askew that a candidate may be, to win a whole half range of margin
)


@dataclass(frozen=True, eq=False)
class GraspPlan:
    """How the sheet is taken and pulled, every path checked."""

    candidate: GraspCandidate
    reach: tuple[Path, ...]  # to the grasp, in order; empty where the jaws are there
    pull: Path
    retreat: Path  # from the grasp, out of the tissue


def choose_grasp(planner: Planner, q: Vector) -> GraspPlan:
    """Plan the grasp from q (9,) [rad]; the same q always gives the same.

    Candidates are ranked by how square the jaws stand to the sheet and by the joints' margin to
    their limits. The first is taken from which everything up to the retreat keeps all limits.

    Raises:
        Infeasible: No candidate keeps all limits; where there was a choice it is a `NoGrasp`.
    """
    if len(planner.grasp_candidates) == 1:
        return _plan(planner, q, planner.grasp_candidates[0])
    reasons: list[Infeasible] = []
    for candidate in _ranked(planner, q)[:MAX_PLANNED]:
        try:
            return _plan(planner, q, candidate)
        except Infeasible as reason:
            reasons.append(reason)
    raise NoGrasp(tuple(reasons[:TOLD]), len(planner.grasp_candidates))


def _plan(planner: Planner, q: Vector, candidate: GraspCandidate) -> GraspPlan:
    reach = planner.reach(q, candidate)
    at_grasp = reach[-1].end if reach else q
    return GraspPlan(candidate, reach, planner.pull(at_grasp), planner.retreat(at_grasp))


def _ranked(planner: Planner, q: Vector) -> list[GraspCandidate]:
    """All candidates, the best first; those at which the joints cannot hold the tool come last."""
    costs = []
    for candidate in planner.grasp_candidates:
        posture = planner.solver.settle(q, candidate.T_base_tip, planner.trocar)
        lacking = max(0.0, ENOUGH_MARGIN - _margin(planner, posture.q))
        costs.append((not posture.is_solved, round(candidate.askew + MARGIN_WEIGHT * lacking, 9)))
    order = sorted(range(len(costs)), key=costs.__getitem__)
    return [planner.grasp_candidates[i] for i in order]


def _margin(planner: Planner, q: Vector) -> float:
    """Least distance of a joint from its limits, as a share of half its range."""
    limits = planner.limits
    room = np.minimum(q - limits.lower, limits.upper - q)
    return float((2.0 * room / (limits.upper - limits.lower)).min())
