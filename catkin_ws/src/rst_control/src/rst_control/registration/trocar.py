# SPDX-License-Identifier: BSD-3-Clause
"""Setting the trocar while the controller runs: only at rest, and only to where the shaft is.

The shaft is in the true trocar while this is asked, so a point far from the shaft cannot be it. The
tolerance is never above the one that motion keeps: what is accepted here, the next command puts
right by itself as its first leg.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from typing import Final

from rst_control.config import WatchdogConfig
from rst_control.errors import InsertionOutOfRange
from rst_control.execution.event_log import Event
from rst_control.execution.executor import Executor
from rst_control.execution.orders import Reply
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.registration.trocar_context import (
    ActiveTrocarContext,
    TrocarContext,
    TrocarOutOfReach,
)
from rst_control.robot.health import joint_in_motion
from rst_control.types import NOT_CONNECTED, Cause, Measurement, Reason, State, Vector

COMMAND: Final = "set_trocar"  # as the event log names it


class TrocarRegistrar:
    """Sets the active trocar, with all that depends on it, in one tick of the control loop.

    Args:
        present: The active trocar.
        executor: Runs the control loop and keeps the event log.
    """

    def __init__(self, present: ActiveTrocarContext, executor: Executor) -> None:
        self._present, self._executor = present, executor

    def ask(self, trocar: Sequence[float], caller: str) -> Future[Reply]:
        """Ask for another trocar; any thread may. Cancel the answer to withdraw the question.

        Args:
            trocar: Base frame, [m]. Shape (3,).
            caller: Who asks, for the event log.
        """
        reply: Future[Reply] = Future()
        try:
            context = self._present.current.with_trocar(trocar)
        except TrocarOutOfReach as error:
            now, cause = self._executor.snapshot.stamp, Cause(Reason.UNREACHABLE, str(error))
            self._executor.events.append(_refused(now, cause, caller))
            reply.set_result(Reply.refused(cause))
            return reply
        self._executor.change(lambda view: self._apply(context, caller, reply, view))
        return reply

    def _apply(
        self, context: TrocarContext, caller: str, reply: Future[Reply], view: ControllerSnapshot
    ) -> Event | None:
        if not reply.set_running_or_notify_cancel():
            return None  # the caller waits no longer
        answer = decide(context, view)
        if isinstance(answer, Cause):
            reply.set_result(Reply.refused(answer))
            self._executor.events.append(_refused(view.stamp, answer, caller))
            return None
        reply.set_result(Reply(True, answer))
        was, self._present.current = self._present.current, context
        words = f"{answer}; was {position_words(was.trocar)}; asked by {caller}"
        return Event(view.stamp, "trocar_set", COMMAND, words)


def decide(context: TrocarContext, view: ControllerSnapshot) -> Cause | str:
    """How far off the shaft is, or why the trocar of a context may not become active now."""
    refusal = unrest(view, view.stamp, context.config.controller.watchdogs)
    measured = view.measurement
    if refusal is not None or measured is None:
        return refusal or NOT_CONNECTED
    if view.mode.state is State.FAULTED:
        words = f'halted ({view.mode.reason}); say "hey robot" first'
        return Cause(Reason.HALTED, words)
    if measured.gripped:
        words = "tissue is held, and its ways out lead through the present trocar"
        return Cause(Reason.ALREADY_GRASPED, f'{words}; say "release" first')
    return _decide_shaft(context, measured)


def unrest(view: ControllerSnapshot, now: float, watchdogs: WatchdogConfig) -> Cause | None:
    """Why the robot is not known to be healthy and at rest at a time [s]; None: it is."""
    if view.is_moving:
        words = f"{view.mode.state.value}; wait until the robot is at rest"
        return Cause(Reason.NOT_AT_REST, words)
    measured = view.measurement
    if view.health is not None:
        return view.health
    if measured is None:
        return NOT_CONNECTED
    age, allowed = now - measured.stamp, watchdogs.joint_state_age
    if age > allowed:
        words = f"joint states {age * 1e3:.0f} ms old, allowed {allowed * 1e3:.0f} ms"
        return Cause(Reason.STALE, words)
    return joint_in_motion(measured, watchdogs.at_rest_speed)


def position_words(position: Vector) -> str:
    """A point for people, to the micrometre."""
    x, y, z = position
    return f"({x:.6f}, {y:.6f}, {z:.6f}) m"


def _decide_shaft(context: TrocarContext, measured: Measurement) -> Cause | str:
    shaft, rcm = context.shaft(measured.position), context.config.rcm
    allowed = rcm.registration.tolerance
    words = f"shaft {shaft.error * 1e3:.3f} mm off it, allowed {allowed * 1e3:.3f} mm"
    words = f"trocar {position_words(context.trocar)}: {words}"
    if shaft.error > allowed:
        return Cause(Reason.NOT_THE_TROCAR, words)
    least, most = rcm.insertion
    if not least <= shaft.insertion <= most:
        depth = InsertionOutOfRange(shaft.insertion, least, most)
        return Cause(Reason.INSERTION_DEPTH, str(depth))
    return words


def _refused(stamp: float, cause: Cause, caller: str) -> Event:
    words = f"{cause.words}; asked by {caller}"
    return Event(stamp, "trocar_refused", COMMAND, words, cause.reason)
