# SPDX-License-Identifier: BSD-3-Clause
"""Plans "tense": the best grasp whose reach, pull and retreat are free."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from rst_control.commands.pull_by_distance import DistanceForTension
from rst_control.commands.request import Accepted, PlanningContext
from rst_control.commands.tension_limits import (
    ROUNDING,
    bounded,
    present_refusal,
    target_refusal,
    too_far,
)
from rst_control.errors import Infeasible, NoGrasp
from rst_control.planning.plan import Grasp, Phase, PhaseKind
from rst_control.types import Rejected, Vector

if TYPE_CHECKING:
    from rst_control.planning.planner import Planner
    from rst_control.tissue.grasp_candidates import GraspCandidate
    from rst_control.trajectory.path import Path

MAX_PLANNED: Final = 12  # candidates whose paths are planned, the best first
ENOUGH_MARGIN: Final = 0.15  # share of a joint's half range; more to its limit is no better
MARGIN_WEIGHT: Final = 4.0  # [rad] askew that a candidate may be to win a half range of margin


@dataclass(frozen=True, eq=False)
class GraspPlan:
    """How the sheet is taken and pulled, every path checked."""

    candidate: GraspCandidate
    reach: tuple[Path, ...]  # to the grasp, in order; empty where the jaws are there
    pull: Path
    retreat: Path  # from the grasp, out of the tissue


def plan(context: PlanningContext) -> Accepted | Rejected:
    """Open the jaws, reach the tissue, close them and pull to a tension.

    Where the tension cannot be relied on, the pull goes by distance.

    Raises:
        Infeasible: No way keeps all limits; the error says which.
    """
    config, request = context.config.tension, context.request
    target = request.tension or config.initial
    is_trusted = not context.measured.tension_invalid_reason
    refusal = target_refusal(target, config)
    if refusal is None and is_trusted:  # else opened jaws may set it right
        refusal = present_refusal(context.measured, config)
    if refusal is not None:
        return refusal
    chosen = choose_grasp(context.planner, context.q)
    by_distance = DistanceForTension(config)
    length = min(chosen.pull.length, by_distance.bound)
    why = by_distance.why(context.measured)
    maximum = min(length, by_distance.distance(target)) if why else length
    if request.distance > maximum + ROUNDING:
        return too_far(request.distance, maximum)
    furthest = min(request.distance or maximum, maximum)
    tension = None if why else bounded(target, config)
    words = f"reaches, grasps and pulls to {target:.2f} N"
    if why:
        words = f"reaches, grasps and pulls {furthest * 1e3:.1f} mm{by_distance.words(why)}"
    grasp = Grasp(chosen.pull, chosen.retreat, 0.0 if tension else furthest, tension)
    return context.accept(words, _phases(context, chosen, furthest, tension), grasp)


def _phases(
    context: PlanningContext, chosen: GraspPlan, furthest: float, tension: float | None
) -> tuple[Phase, ...]:
    speed = context.config.speed
    pull = context.along(PhaseKind.PULL, chosen.pull, speed.pull_speed)
    return (
        Phase(PhaseKind.OPEN, opening=context.config.jaws.open),
        *(context.along(PhaseKind.REACH, path, speed.tip_speed) for path in chosen.reach),
        Phase(PhaseKind.CLOSE, opening=0.0),
        replace(pull, target=furthest, tension=tension),
    )


def choose_grasp(planner: Planner, q: Vector) -> GraspPlan:
    """Plan the grasp from q (9,) [rad]; the same q always gives the same.

    Candidates are ranked by how square the jaws stand to the sheet and by the joints' margin to
    their limits. The first is taken from which everything up to the retreat keeps all limits.

    Raises:
        Infeasible: No candidate keeps all limits; where there was a choice it is a `NoGrasp`.
    """
    if len(planner.grasp_candidates) == 1:
        return _plan_candidate(planner, q, planner.grasp_candidates[0])
    reasons: list[Infeasible] = []
    for candidate in _ranked(planner, q)[:MAX_PLANNED]:
        try:
            return _plan_candidate(planner, q, candidate)
        except Infeasible as reason:
            reasons.append(reason)
    raise NoGrasp(tuple(reasons))


def _plan_candidate(planner: Planner, q: Vector, candidate: GraspCandidate) -> GraspPlan:
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
