# SPDX-License-Identifier: BSD-3-Clause
"""Values of the core to ROS messages and back."""

from __future__ import annotations

from collections.abc import Sequence

import genpy
import rospy
from geometry_msgs.msg import PointStamped

from rst_control.execution.event_log import Event
from rst_control.execution.orders import Outcome
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.msg import AssistFeedback, AssistResult, ControllerState
from rst_control.msg import Event as EventMessage
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.ros.common.wall_clock import RosClock
from rst_control.types import BASE, LATCHED, Cause, Reason, Vector
from typed_config.node_names import caller_name


def code_of(why: Cause | Reason | None) -> str:
    """A `reason_code` of the messages; empty: there is no reason."""
    reason = why.reason if isinstance(why, Cause) else why
    return "" if reason is None else str(reason.value)


def state_message(
    view: ControllerSnapshot, clock: RosClock, places: ActiveTrocarContext
) -> ControllerState:
    """The controller's state for `rst_control/state`."""
    trocar, grasp = places.trocar_origin, places.grasp_origin
    mode, motion = view.mode, view.motion
    halted, refused = view.latch, view.last_refusal
    message = ControllerState(
        state=mode.state.value,
        phase=view.phase,
        command=view.command,
        assistance_enabled=mode.is_active,
        halted=mode.state in LATCHED,
        halt_reason=halted.words if halted else "",
        halt_reason_code=code_of(halted),
        tissue_held=view.is_tissue_held,
        progress=motion.progress if motion else 1.0,
        path_position=view.path_position,
        path_speed=motion.path_speed if motion else 0.0,
        rcm_error=view.rcm_error,
        insertion=view.insertion,
        tension=view.tension,
        tension_target=view.tension_target,
        trocar_source=trocar.source,
        trocar_age=view.stamp - trocar.stamp,
        grasp_point_source=grasp.source,
        grasp_point_age=view.stamp - grasp.stamp,
        last_refusal=refused.words if refused else "",
        last_refusal_code=code_of(refused),
    )
    message.header.stamp = clock.stamp(view.stamp)
    message.header.frame_id = BASE
    return message


def event_message(event: Event, clock: RosClock) -> EventMessage:
    """An event for `rst_control/event`."""
    message = EventMessage(
        kind=event.kind,
        command=event.command,
        message=event.message,
        reason_code=code_of(event.reason),
        caller=event.caller,
    )
    message.header.stamp = clock.stamp(event.stamp)
    return message


def feedback_message(view: ControllerSnapshot) -> AssistFeedback:
    """Progress of an action goal."""
    return AssistFeedback(
        phase=view.phase,
        progress=view.motion.progress if view.motion else 1.0,
        tension=view.tension,
        rcm_error=view.rcm_error,
    )


def result_message(outcome: Outcome) -> AssistResult:
    """Ending of an action goal."""
    return AssistResult(
        outcome=outcome.kind,
        reason=outcome.message,
        reason_code=code_of(outcome.reason),
        tension=outcome.tension,
        max_rcm_error=outcome.max_rcm_error,
    )


def base_point(place: Sequence[float] | Vector) -> PointStamped:
    """A place [m], frame base_link. Shape (3,)."""
    message = PointStamped()
    message.header.frame_id = BASE
    message.header.stamp = rospy.Time.now()
    message.point.x, message.point.y, message.point.z = map(float, place)
    return message


def caller_of(message: genpy.Message) -> str:
    """Name that the sender of a message or request gave itself when it connected."""
    header = getattr(message, "_connection_header", None) or {}
    return caller_name(header.get("callerid"))
