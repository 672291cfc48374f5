# SPDX-License-Identifier: BSD-3-Clause
"""Changing what all planning refers to while the controller runs: only at rest, in one tick."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import replace
from typing import ClassVar

import numpy as np

from rst_control.config import WatchdogConfig
from rst_control.execution.event_log import Event, EventKind
from rst_control.execution.executor import Executor
from rst_control.execution.orders import Reply
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.registration.trocar_context import ActiveTrocarContext, Origin, TrocarContext
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
        """What is set by another service, and what this one relies on."""

    @abstractmethod
    def _note(self, origin: Origin) -> None:
        """Remember who set the place that is active now."""

    @abstractmethod
    def _make(self, place: Sequence[float], view: ControllerSnapshot) -> TrocarContext | Cause:
        """The present context with another place (3,) [m], or why there is none."""

    @abstractmethod
    def _decide(self, context: TrocarContext, view: ControllerSnapshot) -> Cause | str:
        """In words that it is set, or why a context may not become active now."""

    def ask(self, place: Sequence[float], caller: str) -> Future[Reply]:
        """Ask for another place; any thread may. Cancel the answer to withdraw the question.

        Args:
            place: Base frame, [m]. Shape (3,), or as the registrar says.
            caller: Who asks, for the event log.
        """
        reply: Future[Reply] = Future()
        view = self._executor.snapshot
        made = self._make(place, view)
        if isinstance(made, Cause):
            self._executor.events.append(self._refused(view.stamp, made, caller))
            reply.set_result(Reply.refused(made))
            return reply
        context = made

        def apply(now: ControllerSnapshot) -> Event | None:
            if not reply.set_running_or_notify_cancel():
                return None  # the caller waits no longer
            done = self.activate(context, now, caller)
            if isinstance(done, Cause):
                reply.set_result(Reply.refused(done))
                self._executor.events.append(self._refused(now.stamp, done, caller))
                return None
            words, entry = done
            reply.set_result(Reply(True, words))
            return entry

        self._executor.change(apply)
        return reply

    def activate(
        self, context: TrocarContext, now: ControllerSnapshot, caller: str
    ) -> tuple[str, Event] | Cause:
        """Let a context count from now on, in words and as an event, or say why it may not.

        The control loop alone calls it, between two ticks.
        """
        present = self._present.current
        is_overtaken = self._other(present) != self._other(context)
        answer = OVERTAKEN if is_overtaken else self._decide(context, now)
        if isinstance(answer, Cause):
            return answer
        self._present.current = context
        self._note(Origin(caller, now.stamp))
        words = f"{answer}; was {position_words(self._place(present))}; asked by {caller}"
        return answer, Event(now.stamp, self.SET, self.COMMAND, words)

    def _refused(self, stamp: float, cause: Cause, caller: str) -> Event:
        words = f"{cause.words}; asked by {caller}"
        return Event(stamp, self.REFUSED, self.COMMAND, words, cause.reason)


def ready(context: TrocarContext, view: ControllerSnapshot) -> Measurement | Cause:
    """What is measured of a robot at rest that holds nothing; else why it is not ready."""
    refusal = unrest(view, view.stamp, context.config.controller.watchdogs)
    measured = view.measurement
    if refusal is not None and refusal.reason is Reason.ARM_IN_USE:
        return replace(refusal, words=f'{refusal.words}; let go of the arm, say "hey robot" first')
    if refusal is not None or measured is None:
        return refusal or NOT_CONNECTED
    if view.mode.state is State.FAULTED:
        words = f'halted ({view.mode.reason}); say "hey robot" first'
        return Cause(Reason.HALTED, words)
    if measured.gripped:
        words = "tissue is held, and its ways out lead through the present trocar"
        return Cause(Reason.ALREADY_GRASPED, f'{words}; say "release" first')
    return measured


def unrest(
    view: ControllerSnapshot, now: float, watchdogs: WatchdogConfig, may_be_guided: bool = False
) -> Cause | None:
    """Why the robot is not known to be healthy and at rest at a time [s]; None: it is.

    Args:
        view: The executor's.
        now: Time [s], the clock of the measurement.
        watchdogs: What counts as recent, and as rest.
        may_be_guided: A hand on the arm, for which the robot's side let go of it, is no fault.
    """
    if view.is_moving:
        words = f"{view.mode.state.value}; wait until the robot is at rest"
        return Cause(Reason.NOT_AT_REST, words)
    measured = view.measurement
    health = view.health
    if health is not None and not (may_be_guided and health.reason is Reason.ARM_IN_USE):
        return health
    if measured is None:
        return NOT_CONNECTED
    age, allowed = now - measured.stamp, watchdogs.joint_state_age
    if age > allowed:
        words = f"joint states {age * 1e3:.0f} ms old, allowed {allowed * 1e3:.0f} ms"
        return Cause(Reason.STALE, words)
    return joint_in_motion(measured, watchdogs.at_rest_speed)


def place_words(present: ActiveTrocarContext, now: float) -> dict[str, str]:
    """Trocar and grasp point as they count at a time [s], with who set them and when."""
    scene = present.current.config.scene
    places = (
        ("trocar", scene.trocar, present.trocar_origin),
        ("grasp point", scene.grasp_point, present.grasp_origin),
    )
    return {
        name: f"{position_words(np.array(place))}, {origin.source}, {now - origin.stamp:.0f} s old"
        for name, place, origin in places
    }


def position_words(position: Vector) -> str:
    """A point for people, to the micrometre."""
    x, y, z = position
    return f"({x:.6f}, {y:.6f}, {z:.6f}) m"
