# SPDX-License-Identifier: BSD-3-Clause
"""The life of a command: accepted, moved tick by tick, finished, or braked and latched.

One thread calls `tick`; it owns all state. Others only post orders, ask for a stop or report a
heartbeat, which the next tick takes up. Nothing here plans, waits or reads a clock.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable

import numpy as np

from rst_control.commands.preconditions import mode_refusal
from rst_control.commands.spec import STOP, Role
from rst_control.execution import state_machine
from rst_control.execution.event_log import Event, EventKind, EventLog
from rst_control.execution.fault_reset import FaultReset
from rst_control.execution.inbox import Inbox
from rst_control.execution.measured_robot import MeasuredRobot
from rst_control.execution.motion import Motion
from rst_control.execution.orders import GIVEN_UP, OUTRUN, Order, Outcome, OutcomeKind
from rst_control.execution.setpoint import STILL, SetpointState
from rst_control.execution.setting_plan import change_by
from rst_control.execution.snapshot import Change, ControllerSnapshot, take_snapshot
from rst_control.planning.patient_surface import TrocarPose
from rst_control.supervision.tension_trust import TensionTrust
from rst_control.supervision.watchdogs import MonitoredMotion, Watchdogs
from rst_control.types import (
    JOINT_COUNT,
    LATCHED,
    Cause,
    ControllerMode,
    Measurement,
    Reason,
    Setpoint,
    State,
    Vector,
)

log = logging.getLogger("rosout.rst_control.executor")

MAX_PERIODS = 5  # of the path that one late tick may catch up with


class Executor:
    """Owns the state of the controller and turns orders into set-points.

    Args:
        watchdogs: What makes it brake.
        trocar_pose: Where the tool is towards the trocar, for joint positions of shape (10,).
        setpoint_state: Moves the set-point.
        clear_fault: Asks the robot to take set-points again.
        period: Time between ticks [s].
        tension_trust: Whether the tension is relied on.
    """

    def __init__(
        self,
        watchdogs: Watchdogs,
        trocar_pose: Callable[[Vector], TrocarPose],
        setpoint_state: SetpointState,
        clear_fault: Callable[[], None],
        period: float,
        tension_trust: TensionTrust,
    ) -> None:
        self._watchdogs, self._inbox = watchdogs, Inbox()
        self._robot = MeasuredRobot(watchdogs, trocar_pose, tension_trust)
        self._setpoint_state, self._period = setpoint_state, period
        self._now = 0.0
        self._mode, self._mode_changes = ControllerMode(), 0
        self._event_log = EventLog()
        self._fault_reset = FaultReset(self._cannot_activate, clear_fault, self._refuse)
        self._heartbeat = -np.inf
        self._changed = 0  # how often what verification relies on was changed from outside
        self._crash: Cause | None = None  # the last tick that raised
        self.latches = 0  # how often all that was commanded before has ended
        self.snapshot = ControllerSnapshot.at_start()

    # From any thread.

    def post(self, order: Order) -> None:
        """Hand over a verified command; the next tick answers it."""
        self._inbox.orders.append(order)

    def stop(self, cause: Cause, received: float | None = None, caller: str = "") -> None:
        """Brake, hold and latch from the next tick on.

        Args:
            cause: Why.
            received: When it came [s], for the event log; None: at that tick.
            caller: Node that asked for it, for the event log; empty: none did.
        """
        self._inbox.stops.append((cause, received, caller))

    def change(self, change: Change) -> None:
        """Let something that verification relies on be changed, within the next tick."""
        self._inbox.changes.append(change)

    def heartbeat(self, now: float) -> None:
        """Note that the voice node is alive."""
        self._heartbeat = now

    def note_refusal(self, command: str, cause: Cause, now: float, caller: str) -> None:
        """Write a refusal into the event log."""
        self._event_log.note_refusal(now, command, cause, caller)

    @property
    def events(self) -> deque[Event]:
        """What happened, oldest first; its publisher empties it."""
        return self._event_log.events

    @property
    def owner(self) -> str:
        """Node that asked for the present motion and has to stay; empty: none has."""
        order = self._event_log.order
        return order.owner if order is not None else ""

    # From the loop's thread.

    def tick(self, now: float, measured: Measurement | None) -> Setpoint | None:
        """Do what is due.

        Args:
            now: Time at which this tick is due [s], the clock of the measurement.
            measured: Newest from the robot; None while it never spoke.

        Returns:
            Where the joints should be now; None where the robot is to hold by itself.
        """
        periods = max(1, min(MAX_PERIODS, round((now - self._now) / self._period)))
        self._now = now
        self._robot.update(now, measured, self._setpoint_state)
        self._take_stops()
        self._take_change()
        self._take_orders()
        self._resume(self._fault_reset.keep(now))
        motion = self._setpoint_state.motion
        velocity = self._rest() if motion is None else self._move(motion, periods)
        self.snapshot, self._crash = self._take_snapshot(), None
        held = self._setpoint_state.held
        return None if held is None else Setpoint(held, velocity, now)

    def crashed(self, error: Exception) -> None:
        """After a tick raised: brake along the path; where that raises too, let the robot hold."""
        cause = Cause(Reason.LOOP_ERROR, f"error in the control loop: {error!r}"[:300])
        if self._crash != cause:  # the same at each tick is logged once
            self._crash = cause
            log.error(cause.words, exc_info=error)
        if self._setpoint_state.motion is not None and self._mode.mode_after is not State.FAULTED:
            self._fault(cause)
        else:
            self._setpoint_state.lose()
            self._latch(state_machine.at_rest(state_machine.faulted(self._mode, cause)))
            self._end_order("failed", cause)
        self.snapshot = self._take_snapshot()  # the tick did not come to it

    def _take_stops(self) -> None:
        for cause, received, caller in self._inbox.take_stops():
            self._event_log.note(received or self._now, "stop_received", STOP, cause, caller)
            self._fault_reset.drop(Cause(Reason.WITHDRAWN, "stopped"))
            self._latch(state_machine.stopped(self._mode, cause))

    def _take_change(self) -> None:
        if self._inbox.changes:
            entry = self._inbox.changes.popleft()(self._take_snapshot())
            if entry is not None:
                self._note_change(entry)

    def _note_change(self, entry: Event) -> None:
        self._changed += 1
        self.events.append(entry)
        self._robot.locate()

    def _set_up(self, order: Order) -> None:
        done = change_by(order, self._take_snapshot())
        if isinstance(done, Cause):
            self._refuse(order, done)
            return
        self._note_change(done)
        self._event_log.accept(self._now, order)
        order.ended(Outcome("succeeded", ""))

    def _take_orders(self) -> None:
        for order in self._inbox.take_orders():
            refusal = mode_refusal(order.command, self._mode) or self._outrun(order)
            if refusal is not None:
                self._refuse(order, refusal)
            elif order.serial != self._serial and order.stale is not None:
                order.stale()
            elif not order.claim():
                self._refuse(order, GIVEN_UP)
            elif order.command.role is Role.ACTIVATE:
                self._resume(self._fault_reset.take(order, self._now))
            elif order.command.role is Role.TERMINATE:
                self._terminate(order)
            elif order.command.role is Role.SET_UP:
                self._set_up(order)
            else:
                self._start(order)

    def _outrun(self, order: Order) -> Cause | None:
        """Why "hey robot" clears nothing that the robot was latched by after it was given."""
        if order.latches == self.latches or order.command.role is not Role.ACTIVATE:
            return None
        return Cause(Reason.HALTED, OUTRUN)

    def _start(self, order: Order) -> None:
        refusal = self._robot.health or self._watchdogs.owner(order.owner)
        refusal = refusal or self._setpoint_state.start(order.plan, self._now)
        if refusal is not None:
            self._refuse(order, refusal)
            return
        replaced = f'replaced by "{order.plan.command_words}"'
        self._end_order("stopped", Cause(Reason.REPLACED, replaced))
        if self._mode.state is not State.MOVING:
            self._robot.max_rcm_error = self._robot.trocar_pose.rcm_error
        self._event_log.order = order
        self._change(state_machine.started(self._mode))
        order.started()
        self._event_log.accept(self._now, order)
        self._note("motion_started", order.plan.command_words, order.plan.words)

    def _terminate(self, order: Order) -> None:
        self._fault_reset.drop(Cause(Reason.WITHDRAWN, "terminated"))
        self._event_log.accept(self._now, order)
        order.ended(Outcome("succeeded", ""))
        self._latch(state_machine.terminated(self._mode))

    def _cannot_activate(self) -> Cause | None:
        is_led = self._setpoint_state.motion is not None
        return self._watchdogs.activation(self._now, self._robot.measurement, is_led)

    def _resume(self, order: Order | None) -> None:
        if order is None:
            return
        was = self._mode
        refusal = mode_refusal(order.command, was)  # it may have waited, and the robot brake since
        if refusal is not None:
            self._refuse(order, refusal)
            return
        self._robot.synchronise_if_elsewhere(self._setpoint_state)
        self._event_log.accept(self._now, order)
        order.ended(Outcome("succeeded", ""))
        self._change(state_machine.activated(was))
        if was.is_latched:
            self._note("cleared", order.command.phrase, was.cause or "")

    def _move(self, motion: Motion, periods: int) -> Vector:
        self._watch(motion)
        velocity = self._setpoint_state.advance(periods, self._robot.measurement, self._now)
        if motion.failure and self._mode.state is State.MOVING:
            self._latch(state_machine.failed(self._mode))
        if motion.is_done:
            self._finish(motion)
        return velocity

    def _watch(self, motion: Motion) -> None:
        if self._mode.state is State.STOPPING and self._mode.mode_after is State.FAULTED:
            return
        # Braking to a latch needs no voice: its heartbeat pauses after a stop.
        is_heard = self._event_log.is_spoken and not self._mode.is_latched
        held = self._setpoint_state.held
        watched = MonitoredMotion(
            setpoint=np.zeros(JOINT_COUNT) if held is None else held,
            trocar_pose=self._robot.trocar_pose,
            raises_tension=motion.raises_tension,
            needs_grip=motion.needs_grip,
            overtime=motion.overtime(self._now),
            heartbeat_age=self._now - self._heartbeat if is_heard else None,
            owner=self.owner,
            only_opens=motion.only_opens,
            easing_since=motion.easing_since,
        )
        self._fault(self._watchdogs.motion(self._now, self._robot.measurement, watched))

    def _finish(self, motion: Motion) -> None:
        was, command = self._mode, self._event_log.command
        self._setpoint_state.finish()
        self._change(state_machine.at_rest(was))
        if was.state is State.MOVING:
            self._note("motion_finished", command, f"tension {self._robot.tension:.2f} N")
            self._end_order("succeeded", None)
            return
        ended = motion.failure or Cause(Reason.TERMINATED, "terminated")
        cause = was.cause if was.is_latched and was.cause else ended
        self._note("at_rest", command, cause)
        self._note_latch()
        is_asked_for = was.mode_after in (State.HALTED, State.STANDBY)
        self._end_order("stopped" if is_asked_for else "failed", cause)

    def _rest(self) -> Vector:
        measured = self._robot.measurement
        self._fault(self._watchdogs.master())
        lost = self._watchdogs.robot(self._now, measured)
        if lost is not None and lost.reason is not Reason.STALE:
            self._setpoint_state.lose()
            self._fault(lost)
        elif lost is None and measured is not None:
            self._keep_still(measured, self._setpoint_state.held)
        return STILL

    def _keep_still(self, measured: Measurement, held: Vector | None) -> None:
        if held is None:
            if self._watchdogs.is_at_rest(measured):
                self._robot.synchronise(self._setpoint_state)
        elif self._mode.state is State.ACTIVE:
            self._fault(self._watchdogs.following(measured, held))
        if not measured.gripped:
            self._setpoint_state.drop_grasp()

    @property
    def _serial(self) -> int:
        return self._mode_changes + self._setpoint_state.changes + self._changed

    def _change(self, mode: ControllerMode) -> None:
        if mode != self._mode:
            self._mode = mode
            self._mode_changes += 1

    def _latch(self, mode: ControllerMode) -> None:
        """Take a state in which nothing moves; brake where something does."""
        self.latches += 1
        was = self._mode
        is_noted = was.state in LATCHED and was.cause == mode.cause
        self._change(mode)
        motion = self._setpoint_state.motion
        if motion is not None:
            motion.brake()
        elif not is_noted:
            self._note_latch()

    def _fault(self, cause: Cause | None) -> None:
        mode = self._mode if cause is None else state_machine.faulted(self._mode, cause)
        if mode != self._mode:
            self._fault_reset.drop(Cause(Reason.WITHDRAWN, "it came before a fault"))
            self._latch(mode)

    def _refuse(self, order: Order, cause: Cause) -> None:
        self._event_log.refuse(self._now, order, cause, self._robot.tension)

    def _end_order(self, kind: OutcomeKind, cause: Cause | None) -> None:
        self._event_log.end(kind, cause, self._robot.tension, self._robot.max_rcm_error)

    def _note(self, kind: EventKind, command: str, why: Cause | str) -> None:
        self._event_log.note(self._now, kind, command, why)

    def _note_latch(self) -> None:
        if self._mode.state in LATCHED:
            self._note("halted", self._event_log.command, self._mode.cause or "")

    def _take_snapshot(self) -> ControllerSnapshot:
        parts = (self._setpoint_state, self._event_log, self._robot.trocar_pose)
        pulled = self._robot.pulled(self._setpoint_state.held)
        situation = (self._robot.measurement, self._robot.health, pulled)
        return take_snapshot(self._now, self._mode, self._serial, *parts, *situation)
