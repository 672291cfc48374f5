# SPDX-License-Identifier: BSD-3-Clause
"""Plans "nudge": a little further in along the shaft and back. Written as a file of `commands/`."""

from __future__ import annotations

from typing import Final

from rst_control.commands.request import Accepted, PlanningContext
from rst_control.kinematics.configuration import Configuration
from rst_control.planning.plan import PhaseKind

LENGTH: Final = 2e-3  # [m]


def plan(context: PlanningContext) -> Accepted:
    """Plan the way in and the same way back.

    Raises:
        Infeasible: The way in breaks a limit; the error says which.
    """
    here = Configuration(context.planner.model, context.q)
    goal = here.T_base_tip
    goal[:3, 3] += LENGTH * here.T_base_shaft[:3, 2]
    paths, speed = context.planner.route(context.q, goal), context.config.speed.insertion
    phases = [context.along(PhaseKind.INSERT, path, speed) for path in paths]
    phases.append(context.along(PhaseKind.WITHDRAW, paths[-1].reversed(), speed))
    return context.accept(f"goes in by {LENGTH * 1e3:.0f} mm and back", phases)
