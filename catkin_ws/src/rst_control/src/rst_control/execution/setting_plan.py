# SPDX-License-Identifier: BSD-3-Clause
"""A verified command that moves nothing, and changes what planning refers to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rst_control.commands.request import Plan
from rst_control.execution.event_log import Event
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.types import Cause


@dataclass(frozen=True, eq=False, kw_only=True)
class SettingPlan(Plan):
    """What the control loop changes between two ticks, for the caller who asked.

    `change` gives what was done, in words and as an event, or why it may not be done now. It is
    quick and never raises.
    """

    change: Callable[[ControllerSnapshot, str], tuple[str, Event] | Cause]
