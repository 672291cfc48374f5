# SPDX-License-Identifier: BSD-3-Clause
"""Plans "release": the jaws open, then the tool backs out by paths checked when it grasped."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rst_control.commands.held_tissue import remembered, seated
from rst_control.commands.preconditions import is_off_trocar
from rst_control.commands.request import Accepted, PlanningContext
from rst_control.errors import Infeasible
from rst_control.planning.plan import Grasp, Phase, PhaseKind

if TYPE_CHECKING:
    from rst_control.trajectory.path import Path


def plan(context: PlanningContext) -> Accepted:
    """Open the jaws, go back along the pull, then out of the tissue."""
    found = remembered(context)
    if _is_measured_off_trocar(context):
        eases: list[Phase] = []
    elif found is None:
        eases = _unplanned_retreat(context)
    else:
        eases = _way_back(context, *found)
    opening = Phase(PhaseKind.OPEN, opening=context.config.jaws.open)
    words = (
        "opens the jaws and eases off" if eases else "opens the jaws; no way out keeps all limits"
    )
    return context.accept(words, (opening, *eases))


def _is_measured_off_trocar(context: PlanningContext) -> bool:
    """So far that the arm may not move: opening the jaws has to do."""
    return is_off_trocar(context.trocar_pose, context.planner.config.rcm.measured_tolerance)


def _way_back(context: PlanningContext, grasp: Grasp, ways: tuple[Path, ...]) -> list[Phase]:
    """Onto the pull where the robot is beside it, back along it, then out of the tissue."""
    speed = context.config.speed.tip_speed
    eases = [context.along(PhaseKind.EASE, way, speed) for way in ways]
    if grasp.s > 0.0:
        back = context.along(PhaseKind.EASE, grasp.pull, speed)
        eases.append(replace(back, start=grasp.s, target=0.0))
    return [*eases, context.along(PhaseKind.EASE, grasp.retreat, speed)]


def _unplanned_retreat(context: PlanningContext) -> list[Phase]:
    """A way out from any place; where there is none, opening the jaws has to do."""
    try:
        q, paths = seated(context)
        paths = (*paths, context.planner.retreat(q))
    except Infeasible:
        return []
    speed = context.config.speed.tip_speed
    return [context.along(PhaseKind.EASE, path, speed) for path in paths]
