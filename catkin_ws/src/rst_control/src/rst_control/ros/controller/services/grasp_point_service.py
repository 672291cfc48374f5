# SPDX-License-Identifier: BSD-3-Clause
"""The grasp point on ROS: its latched topic, and the service that sets it."""

from __future__ import annotations

import rospy
from geometry_msgs.msg import PointStamped

from rst_control.admission.callers import CallLimiter
from rst_control.execution.executor import Executor
from rst_control.registration.grasp_point import GraspPointRegistrar
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.ros.controller.messages import base_point, caller_of, code_of
from rst_control.ros.controller.services.admission import Admission, answer_of
from rst_control.srv import SetGraspPoint, SetGraspPointRequest, SetGraspPointResponse


class GraspPointService:
    """Publishes `rst_control/grasp_point`; serves `rst_control/set_grasp_point`.

    Args:
        present: The active trocar and grasp point.
        executor: Runs the control loop.
        limiter: Knows who may set up, and how often.
    """

    def __init__(
        self, present: ActiveTrocarContext, executor: Executor, limiter: CallLimiter
    ) -> None:
        self._present, self._admit = present, Admission(limiter)
        self._registrar = GraspPointRegistrar(present, executor)
        self._topic = rospy.Publisher(
            "rst_control/grasp_point", PointStamped, queue_size=1, latch=True
        )
        self._publish()

    def start(self) -> None:
        """Begin to serve."""
        self._service = rospy.Service("rst_control/set_grasp_point", SetGraspPoint, self._on_set)

    def _publish(self) -> None:
        self._topic.publish(base_point(self._present.current.config.scene.grasp_point))

    def _on_set(self, request: SetGraspPointRequest) -> SetGraspPointResponse:
        reply = self._admit.refusal(request)
        if reply is None:
            p = request.position
            reply = answer_of(self._registrar.ask((p.x, p.y, p.z), caller_of(request)))
            if reply.accepted:
                self._publish()
        return SetGraspPointResponse(reply.accepted, reply.message, code_of(reply.reason))
