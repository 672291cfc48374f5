# SPDX-License-Identifier: BSD-3-Clause
"""The grasp that a pull or a release starts from: as remembered, or planned from here."""

from __future__ import annotations

from typing import Final

import numpy as np

from rst_control.commands.request import PlanningContext
from rst_control.planning.plan import Grasp, Phase, PhaseKind
from rst_control.trajectory.path import Path
from rst_control.types import Vector

NEAR: Final = 2e-3  # [rad] that joints may be away from where the grasp says they are


def remembered(context: PlanningContext) -> Grasp | None:
    """The grasp of the last plan, if the robot is still where that plan left it."""
    grasp = context.situation.grasp
    if grasp is None or context.situation.is_moving:
        return grasp
    distance = float(np.abs(context.q - grasp.pull.evaluate(grasp.s).q).max())
    return grasp if distance <= NEAR else None


def held(context: PlanningContext) -> tuple[Grasp, tuple[Phase, ...]]:
    """The grasp, planned from here if none is remembered, and the phases before a pull.

    Raises:
        Infeasible: No pull from here keeps all limits; the error says which.
    """
    grasp = remembered(context)
    if grasp is not None:
        return grasp, ()
    q, paths = seated(context)
    speed = context.config.speed.pull_speed
    phases = tuple(context.along(PhaseKind.STEP, path, speed) for path in paths)
    return Grasp(context.planner.pull(q), context.planner.retreat(q)), phases


def seated(context: PlanningContext) -> tuple[Vector, tuple[Path, ...]]:
    """Joints (9,) [rad] with the shaft in the trocar, and the paths that lead there.

    Raises:
        Infeasible: The shaft is too far off the trocar.
    """
    paths = context.planner.route(context.q)
    return (paths[-1].end if paths else context.q), paths
