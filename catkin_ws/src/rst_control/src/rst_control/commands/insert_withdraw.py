# SPDX-License-Identifier: BSD-3-Clause
"""Makes "insert" and "withdraw" plans: the jaws closed, then the ways one after the other."""

from __future__ import annotations

from rst_control.planning.insertion import Insertion
from rst_control.planning.plan import Accepted, Phase, PhaseKind, Plan, Rejected
from rst_control.planning.planner import Planner, along
from rst_control.types import Command, Measurement, Reason, Vector


class InsertionPlans:
    """Plans for one robot and scene.

    Args:
        planner: Its configuration holds all limits.
    """

    def __init__(self, planner: Planner) -> None:
        self._planner, self._ways = planner, Insertion(planner)

    def warm_up(self) -> None:
        """Compile or load all that insertion calls."""
        self._ways.warm_up()

    def __call__(self, command: Command, q: Vector, measured: Measurement) -> Accepted | Rejected:
        """Plan "insert" or "withdraw" from q (9,) [rad].

        Raises:
            Infeasible: No way keeps all limits; the error says which.
        """
        if measured.gripped:
            words = f'tissue held, "{command.value}" needs empty jaws; release first'
            return Rejected(Reason.ALREADY_GRASPED, words)
        is_in = command is Command.INSERT
        legs = self._ways.insert(q) if is_in else self._ways.withdraw(q)
        speed = self._planner.config.controller.speed
        phases = [Phase(PhaseKind.ALIGN, opening=0.0)]
        for leg in legs:
            most = speed.approach if leg.kind is PhaseKind.APPROACH else speed.insertion
            phases.append(along(self._planner, leg.kind, leg.path, most))
        end = self._planner.patient.trocar_pose(legs[-1].path.end).insertion
        place = f"{abs(end) * 1e3:.0f} mm {'inside' if end > 0.0 else 'outside'} the trocar"
        words = f"{'inserts' if is_in else 'withdraws'} the tool to {place}"
        return Accepted(Plan(command, words, tuple(phases)))
