# SPDX-License-Identifier: BSD-3-Clause
"""The service that sets the grasp point, in any frame that tf joins."""

from __future__ import annotations

import rospy

from rst_control.admission.callers import CallLimiter
from rst_control.execution.orders import Reply
from rst_control.registration.grasp_point import GraspPointRegistrar
from rst_control.ros.controller.messages import caller_of, code_of
from rst_control.ros.controller.places.frame_listener import FrameListener
from rst_control.ros.controller.places.places_in_force import PlacesInForce
from rst_control.ros.controller.services.admission import SetUpCallers, answer_of
from rst_control.srv import SetGraspPoint, SetGraspPointRequest, SetGraspPointResponse
from rst_control.types import Cause


class GraspPointService:
    """Serves `rst_control/set_grasp_point`.

    Args:
        registrar: Sets the grasp point.
        places: Publishes it.
        frames: Knows other frames.
        limiter: Knows who may set up, and how often.
    """

    def __init__(
        self,
        registrar: GraspPointRegistrar,
        places: PlacesInForce,
        frames: FrameListener,
        limiter: CallLimiter,
    ) -> None:
        self._registrar, self._places, self._frames = registrar, places, frames
        self._admit = SetUpCallers(limiter)

    def start(self) -> None:
        """Begin to serve."""
        self._service = rospy.Service("rst_control/set_grasp_point", SetGraspPoint, self._on_set)

    def _on_set(self, request: SetGraspPointRequest) -> SetGraspPointResponse:
        reply = self._admit.refusal(request) or self._set(request)
        return SetGraspPointResponse(reply.accepted, reply.message, code_of(reply.reason))

    def _set(self, request: SetGraspPointRequest) -> Reply:
        T = self._frames.in_base(request.frame)
        if isinstance(T, Cause):
            return Reply.refused(T)
        p, way = request.position, request.pull_direction
        point = T[:3, :3] @ [p.x, p.y, p.z] + T[:3, 3]
        pull = T[:3, :3] @ [way.x, way.y, way.z]
        place = (*point.tolist(), *(pull.tolist() if pull.any() else ()))
        reply = answer_of(self._registrar.ask(place, caller_of(request)))
        self._places.step()
        return reply
