# SPDX-License-Identifier: BSD-3-Clause
"""Plans "insert" and "withdraw": the jaws closed, then the paths one after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rst_control.commands.request import Accepted, PlanningContext
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.types import Reason, Rejected

if TYPE_CHECKING:
    from rst_control.planning.insertion import Leg


def insert(context: PlanningContext) -> Accepted | Rejected:
    """Plan the way in to the working pose.

    Raises:
        Infeasible: No way keeps all limits; the error says which.
    """
    place, minimum = context.trocar_pose, context.planner.config.rcm.insertion[0]
    if place.wrist >= minimum and not place.is_outside:
        words = f"already inserted: {place.wrist * 1e3:.1f} mm of shaft inside the trocar"
        return Rejected(Reason.ALREADY_THERE, words)
    return _accepted(context, "inserts", context.insertion.insert(context.q))


def withdraw(context: PlanningContext) -> Accepted | Rejected:
    """Plan the way out of the patient.

    Raises:
        Infeasible: No way keeps all limits; the error says which.
    """
    place = context.trocar_pose
    if place.is_outside:
        words = f"already outside: tip {-place.insertion * 1e3:.1f} mm outside the trocar"
        return Rejected(Reason.ALREADY_THERE, words)
    return _accepted(context, "withdraws", context.insertion.withdraw(context.q))


def _accepted(context: PlanningContext, verb: str, legs: tuple[Leg, ...]) -> Accepted:
    speed, phases = context.config.speed, [Phase(PhaseKind.ALIGN, opening=0.0)]
    for leg in legs:
        fastest = speed.approach if leg.kind is PhaseKind.APPROACH else speed.insertion
        phases.append(context.along(leg.kind, leg.path, fastest))
    end = context.planner.patient.trocar_pose(legs[-1].path.end).insertion
    place = f"{abs(end) * 1e3:.0f} mm {'inside' if end > 0.0 else 'outside'} the trocar"
    return context.accept(f"{verb} the tool to {place}", phases)
