# SPDX-License-Identifier: BSD-3-Clause
"""A verified command that moves nothing, and changes what planning refers to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rst_control.commands.request import Plan
from rst_control.execution.event_log import Event
from rst_control.execution.orders import Order
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.types import Cause, Reason


@dataclass(frozen=True, eq=False, kw_only=True)
class SettingPlan(Plan):
    """What the control loop changes between two ticks, for the caller who asked.

    `change` gives what was done, in words and as an event, or why it may not be done now. It is
    quick and never raises.
    """

    change: Callable[[ControllerSnapshot, str], tuple[str, Event] | Cause]


def change_by(order: Order, snapshot: ControllerSnapshot) -> Event | Cause:
    """Carry out the change that an order asks for; gives its event, or why it is refused."""
    plan = order.plan
    if not isinstance(plan, SettingPlan):
        return Cause(Reason.CHECK_FAILED, f'"{order.command.phrase}" was not prepared')
    done = plan.change(snapshot, order.caller)
    return done if isinstance(done, Cause) else done[1]
