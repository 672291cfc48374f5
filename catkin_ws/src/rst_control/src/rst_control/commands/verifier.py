# SPDX-License-Identifier: BSD-3-Clause
"""Decides whether a command may run: its whole path is checked before anything moves."""

from __future__ import annotations

from typing import Final

from rst_control.commands.preconditions import Preconditions, mode_refusal
from rst_control.commands.request import Accepted, Plan, PlanningContext, Request, Situation
from rst_control.commands.spec import LimitOfCommand
from rst_control.errors import (
    Collision,
    Infeasible,
    InsertionOutOfRange,
    JointLimitExceeded,
    LongWay,
    NearSingular,
    NoGrasp,
    OutsideWorkspace,
    TrocarDrift,
)
from rst_control.planning.free_space import NoWay
from rst_control.planning.insertion import Insertion
from rst_control.planning.planner import Planner
from rst_control.types import Reason, Rejected

REASONS: Final[dict[type[Infeasible], Reason]] = {
    JointLimitExceeded: Reason.JOINT_LIMIT,
    TrocarDrift: Reason.RCM_TOLERANCE,
    OutsideWorkspace: Reason.WORKSPACE,
    InsertionOutOfRange: Reason.INSERTION_DEPTH,
    Collision: Reason.COLLISION,
    NoWay: Reason.COLLISION,
    NearSingular: Reason.SINGULAR,
    LongWay: Reason.JOINT_LIMIT,
}


class Verifier:
    """Turns a request and a situation into a plan or a refusal with its reason.

    Args:
        planner: For this robot and scene; its configuration holds all limits.
    """

    def __init__(self, planner: Planner) -> None:
        self._planner, self._insertion = planner, Insertion(planner)
        self._preconditions = Preconditions(planner)

    def warm_up(self) -> None:
        """Compile or load all that verification calls."""
        self._planner.warm_up()
        self._insertion.warm_up()

    def __call__(self, request: Request, situation: Situation) -> Accepted | Rejected:
        """Decide; never raises for what a person may ask."""
        command, measured = request.command, situation.measurement
        refusal = mode_refusal(command, situation.mode)
        refusal = refusal or self._preconditions.refusal(command, situation)
        if refusal is not None:
            return refusal
        if command.plan is None or measured is None:  # a motion without one was refused
            return Accepted(Plan(command, command.reply))
        context = PlanningContext(self._planner, self._insertion, request, situation, measured)
        try:
            return command.plan(context)
        except Infeasible as error:
            return Rejected(reason_of(error), f'cannot "{command.phrase}": {error}')


def reason_of(error: Infeasible) -> Reason:
    """The limit that is broken; of several ways to grasp, where all break the same one."""
    if isinstance(error, LimitOfCommand):
        return error.reason
    if isinstance(error, NoGrasp):
        reasons = {reason_of(cause) for cause in error.reasons}
        return reasons.pop() if len(reasons) == 1 else Reason.NO_GRASP
    return REASONS.get(type(error), Reason.UNREACHABLE)
