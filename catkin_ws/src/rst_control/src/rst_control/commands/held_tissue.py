# SPDX-License-Identifier: BSD-3-Clause
"""The grasp that a pull or a release starts from: as remembered, or planned from here."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from rst_control.commands.request import PlanningContext
from rst_control.commands.spec import Load
from rst_control.errors import Infeasible
from rst_control.planning.plan import Grasp, Phase, PhaseKind
from rst_control.types import Vector

if TYPE_CHECKING:
    from rst_control.trajectory.path import Path

NEAR: Final = 3e-3  # [rad] that joints may be beside the pull's path to be led back onto it
SAME: Final = 1e-6  # [rad] beside their place on it that is none
OWN_STOP: Final = 5e-3  # [m] of pull that a robot's own stop may end away from its set-point


def remembered(context: PlanningContext) -> tuple[Grasp, tuple[Path, ...]] | None:
    """The grasp of the last plan, with the way onto its pull; None: the robot is not near it.

    A robot that stopped by itself is not where its set-point was. The place on the pull is then
    the one nearest to the tip. So the way onto it leads across, and pulls the tissue no harder.
    """
    grasp = context.situation.grasp
    if grasp is None:
        return None
    if context.situation.is_moving or _distance(context, grasp) <= SAME:
        return grasp, ()
    here = replace(grasp, s=_place_on(grasp.pull, context), tension=None)
    if not (_distance(context, here) <= NEAR and abs(here.s - grasp.s) <= OWN_STOP):
        return None
    try:
        return here, (context.planner.seat(context.q, here.pull.evaluate(here.s).q),)
    except Infeasible:
        return None


def held(context: PlanningContext) -> tuple[Grasp, tuple[Phase, ...]]:
    """The grasp, planned from here if none is remembered, and the phases before a pull.

    Raises:
        Infeasible: No pull from here keeps all limits; the error says which.
    """
    found, speed = remembered(context), context.config.speed.pull_speed
    if found is not None:
        grasp, ways = found
        return grasp, tuple(_onto_pull(context, way, speed) for way in ways)
    q, paths = seated(context)
    phases = tuple(context.along(PhaseKind.STEP, path, speed) for path in paths)
    return Grasp(context.planner.pull(q), context.planner.retreat(q)), phases


def seated(context: PlanningContext) -> tuple[Vector, tuple[Path, ...]]:
    """Joints (9,) [rad] with the shaft in the trocar, and the paths that lead there.

    Raises:
        Infeasible: The shaft is too far off the trocar.
    """
    paths = context.planner.route(context.q)
    return (paths[-1].end if paths else context.q), paths


def _distance(context: PlanningContext, grasp: Grasp) -> float:
    """Of the joints from where the grasp says they are [rad]."""
    return float(np.abs(context.q - grasp.pull.evaluate(grasp.s).q).max())


def _place_on(pull: Path, context: PlanningContext) -> float:
    """Where the straight pull is nearest to the tip [m]."""
    from rst_control.kinematics.configuration import Configuration

    ends = (pull.start, pull.end, context.q)
    first, last, here = (Configuration(context.planner.model, q).tip for q in ends)
    share = (here - first) @ (last - first) / ((last - first) @ (last - first))
    return float(np.clip(share, 0.0, 1.0)) * pull.length


def _onto_pull(context: PlanningContext, way: Path, speed: float) -> Phase:
    """The way onto the pull.

    Before easing it is a path gone backwards, which the watchdogs take for easing as well. So no
    tension is too high to be eased.
    """
    if context.request.command.load is not Load.EASES:
        return context.along(PhaseKind.STEP, way, speed)
    phase = context.along(PhaseKind.STEP, way.reversed(), speed)
    return replace(phase, start=way.length, target=0.0)
