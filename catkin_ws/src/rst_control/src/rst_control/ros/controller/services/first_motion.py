# SPDX-License-Identifier: BSD-3-Clause
"""The first motion shown on `rst_control/preview`, and confirmed by `rst_control/confirm`."""

from __future__ import annotations

import time

import numpy as np
import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from rst_control.admission.callers import CallLimiter
from rst_control.admission.command_queue import Verify
from rst_control.admission.first_motion_gate import VALID_FOR, FirstMotion
from rst_control.admission.homing_gate import HomingGate
from rst_control.commands.request import Plan
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.ros.common.marker_topic import MarkerTopic
from rst_control.ros.controller.services.admission import SetUpCallers
from rst_control.visualization.controller_shapes import AHEAD, LINE
from rst_control.visualization.shapes import Shape, ShapeKind
from rst_control.visualization.tip_route import PER_KNOT

CONFIRMED = f"confirmed: call robot/home_tool again within {VALID_FOR:.0f} s"
FOR_EVER = 0.0  # [s] lifetime of the markers


class ConfirmedFirst:
    """Verification that asks before the first motion, by ROS.

    Args:
        verify: Decides everything else.
        context: Knows robot and trocar.
        homing: Asks for a confirmation, too.
        limiter: Knows who may confirm, and how often.
    """

    def __init__(
        self,
        verify: Verify,
        context: ActiveTrocarContext,
        homing: HomingGate,
        limiter: CallLimiter,
    ) -> None:
        self._context, self._homing = context, homing
        self._admit = SetUpCallers(limiter)
        self._topic = MarkerTopic("rst_control/preview", FOR_EVER)
        self.verify = FirstMotion(verify, self._show, time.monotonic, lambda: context.current)
        self._service = rospy.Service("rst_control/confirm", Trigger, self._on_confirm)
        rospy.logwarn("dry run: the first motion is shown and has to be confirmed")

    def _on_confirm(self, request: TriggerRequest) -> TriggerResponse:
        if refusal := self._admit.refusal(request):
            return TriggerResponse(False, refusal.message)
        if self._homing.confirm():
            return TriggerResponse(True, CONFIRMED)
        reply = self.verify.confirm()
        return TriggerResponse(reply.accepted, reply.message)

    def _show(self, plan: Plan | None) -> None:
        if plan is not None:
            self._homing.forget()
        paths = [] if plan is None else [p.path for p in plan.phases if p.path is not None]
        context = self._context.current
        tips = [path.sample(context.model.chain, context.trocar, PER_KNOT).tip for path in paths]
        shapes = []
        if tips:
            shapes = [Shape("first motion", ShapeKind.LINE, np.vstack(tips), 2.0 * LINE, AHEAD)]
        self._topic.publish(shapes, rospy.Time.now())
