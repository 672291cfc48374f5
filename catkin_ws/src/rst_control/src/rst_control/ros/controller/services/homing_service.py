# SPDX-License-Identifier: BSD-3-Clause
"""Answers the bridge whether it may home the tool, on `rst_control/may_home_tool`."""

from __future__ import annotations

from collections.abc import Callable

import rospy
from std_srvs.srv import Trigger, TriggerResponse

from rst_control.admission.homing_gate import HomingGate
from rst_control.execution.snapshot import ControllerSnapshot


class HomingService:
    """Offers the service.

    Args:
        gate: Decides.
        view: Present state of the controller.
    """

    def __init__(self, gate: HomingGate, view: Callable[[], ControllerSnapshot]) -> None:
        self._gate, self._view = gate, view
        self._service = rospy.Service("rst_control/may_home_tool", Trigger, self._on_ask)

    def _on_ask(self, _: object) -> TriggerResponse:
        refusal = self._gate.refusal(self._view())
        return TriggerResponse(not refusal, refusal)
