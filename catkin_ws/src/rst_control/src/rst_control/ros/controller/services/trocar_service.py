# SPDX-License-Identifier: BSD-3-Clause
"""The services that set the trocar or fit it to shaft poses."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import rospy
from geometry_msgs.msg import Point
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from rst_control.admission.callers import CallLimiter
from rst_control.execution.executor import Executor
from rst_control.execution.orders import Reply
from rst_control.registration.pivot_calibration import PivotFit, PivotIllPosed
from rst_control.registration.shaft_poses import ShaftPoses, fit_words
from rst_control.registration.trocar import TrocarRegistrar
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.ros.controller.messages import caller_of, code_of
from rst_control.ros.controller.places.places_in_force import PlacesInForce
from rst_control.ros.controller.services.admission import SetUpCallers, answer_of
from rst_control.srv import (
    FitTrocar,
    FitTrocarRequest,
    FitTrocarResponse,
    SetTrocar,
    SetTrocarRequest,
    SetTrocarResponse,
)
from rst_control.types import Reason


class TrocarService:
    """Serves set_trocar, record_shaft, forget_shafts, fit_trocar.

    Args:
        present: The active trocar.
        executor: Runs the control loop.
        places: Publishes the trocar.
        limiter: Knows who may set up, and how often.
    """

    def __init__(
        self,
        present: ActiveTrocarContext,
        executor: Executor,
        places: PlacesInForce,
        limiter: CallLimiter,
    ) -> None:
        self._executor, self._places = executor, places
        self._admit = SetUpCallers(limiter)
        self._registrar = TrocarRegistrar(present, executor)
        config = present.current.config
        self._poses = ShaftPoses(present.current.model, config.rcm, config.controller.watchdogs)
        self._services: list[rospy.Service] = []

    def start(self) -> None:
        """Begin to serve."""
        self._services = [
            rospy.Service("rst_control/set_trocar", SetTrocar, self._on_set),
            rospy.Service("rst_control/record_shaft", Trigger, self._on(self._record)),
            rospy.Service("rst_control/forget_shafts", Trigger, self._on(self._poses.forget)),
            rospy.Service("rst_control/fit_trocar", FitTrocar, self._on_fit),
        ]

    def _on_set(self, request: SetTrocarRequest) -> SetTrocarResponse:
        p = request.position
        reply = self._admit.refusal(request) or self._set((p.x, p.y, p.z), caller_of(request))
        return SetTrocarResponse(reply.accepted, reply.message, code_of(reply.reason))

    def _on_fit(self, request: FitTrocarRequest) -> FitTrocarResponse:
        if refusal := self._admit.refusal(request):
            return _no_fit(refusal)
        try:
            fit = self._poses.fit()
        except PivotIllPosed as error:
            return _no_fit(Reply(False, str(error), Reason.NOT_THE_TROCAR))
        reply = Reply(True, fit_words(fit))
        if request.apply:
            reply = self._set_fitted(fit, reply.message, caller_of(request))
        return _fit_response(reply, fit)

    def _set_fitted(self, fit: PivotFit, words: str, caller: str) -> Reply:
        objection = self._poses.objection(fit)
        if objection:
            return Reply(False, f"{words}; not set: {objection}", Reason.NOT_THE_TROCAR)
        reply = self._set(fit.position.tolist(), f"{caller}, fitted")
        if not reply.accepted:
            return Reply(False, f"{words}; not set: {reply.message}", reply.reason)
        self._poses.forget()
        return Reply(True, f"{words}; set: {reply.message}")

    def _set(self, trocar: Sequence[float], caller: str) -> Reply:
        reply = answer_of(self._registrar.ask(trocar, caller))
        self._places.step()
        return reply

    def _record(self) -> Reply:
        return self._poses.record(self._executor.snapshot, time.monotonic())

    def _on(self, act: Callable[[], Reply]) -> Callable[[TriggerRequest], TriggerResponse]:
        def answer(request: TriggerRequest) -> TriggerResponse:
            reply = self._admit.refusal(request) or act()
            return TriggerResponse(reply.accepted, reply.message)

        return answer


def _no_fit(reply: Reply) -> FitTrocarResponse:
    return FitTrocarResponse(
        accepted=False, message=reply.message, reason_code=code_of(reply.reason)
    )


def _fit_response(reply: Reply, fit: PivotFit) -> FitTrocarResponse:
    return FitTrocarResponse(
        accepted=reply.accepted,
        message=reply.message,
        reason_code=code_of(reply.reason),
        position=Point(*fit.position.tolist()),
        poses=len(fit.residuals),
        rms=fit.rms,
        max_residual=fit.largest,
        position_stddev=fit.deviation,
        angular_spread=fit.spread,
        outliers=[n + 1 for n in fit.outliers],
    )
