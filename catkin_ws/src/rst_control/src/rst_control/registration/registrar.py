# SPDX-License-Identifier: BSD-3-Clause
"""Changing what all planning refers to while the controller runs: only at rest, in one tick."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from concurrent.futures import Future
from typing import ClassVar

from rst_control.config import WatchdogConfig
from rst_control.execution.event_log import Event, EventKind
from rst_control.execution.executor import Executor
from rst_control.execution.orders import Reply
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.registration.trocar_context import ActiveTrocarContext, TrocarContext
from rst_control.robot.health import joint_in_motion
from rst_control.types import NOT_CONNECTED, Cause, Measurement, Reason, State, Vector

OVERTAKEN = Cause(Reason.SITUATION_CHANGING, "something else was set meanwhile; ask again")


class ContextRegistrar(ABC):
    """Replaces the active context by one with another place in it.

    Args:
        present: The active context.
        executor: Runs the control loop and keeps the event log.
    """

    COMMAND: ClassVar[str]  # as the event log names it
    SET: ClassVar[EventKind]
    REFUSED: ClassVar[EventKind]

    def __init__(self, present: ActiveTrocarContext, executor: Executor) -> None:
        self._present, self._executor = present, executor

    @abstractmethod
    def _place(self, context: TrocarContext) -> Vector:
        """What is set: base frame, [m]. Shape (3,)."""

    @abstractmethod
    def _other(self, context: TrocarContext) -> tuple[float, ...]:
        """The place [m] that is set by another service, and that this one relies on."""

    @abstractmethod
    def _make(self, place: Sequence[float], view: ControllerSnapshot) -> TrocarContext | Cause:
        """The present context with another place (3,) [m], or why there is none."""

    @abstractmethod
    def _decide(self, context: TrocarContext, view: ControllerSnapshot) -> Cause | str:
        """In words that it is set, or why a context may not become active now."""

    def ask(self, place: Sequence[float], caller: str) -> Future[Reply]:
        """Ask for another place; any thread may. Cancel the answer to withdraw the question.

        Args:
            place: Base frame, [m]. Shape (3,).
            caller: Who asks, for the event log.
        """
        reply: Future[Reply] = Future()
        view = self._executor.snapshot
        context = self._make(place, view)
        if isinstance(context, Cause):
            self._executor.events.append(self._refused(view.stamp, context, caller))
            reply.set_result(Reply.refused(context))
            return reply
        made = context

        def apply(now: ControllerSnapshot) -> Event | None:
            if not reply.set_running_or_notify_cancel():
                return None  # the caller waits no longer
            present = self._present.current
            is_overtaken = self._other(present) != self._other(made)
            answer = OVERTAKEN if is_overtaken else self._decide(made, now)
            if isinstance(answer, Cause):
                reply.set_result(Reply.refused(answer))
                self._executor.events.append(self._refused(now.stamp, answer, caller))
                return None
            self._present.current = made
            reply.set_result(Reply(True, answer))
            was = position_words(self._place(present))
            words = f"{answer}; was {was}; asked by {caller}"
            return Event(now.stamp, self.SET, self.COMMAND, words)

        self._executor.change(apply)
        return reply

    def _refused(self, stamp: float, cause: Cause, caller: str) -> Event:
        words = f"{cause.words}; asked by {caller}"
        return Event(stamp, self.REFUSED, self.COMMAND, words, cause.reason)


def ready(context: TrocarContext, view: ControllerSnapshot) -> Measurement | Cause:
    """What is measured of a robot at rest that holds nothing; else why it is not ready."""
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
    return measured


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
