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
from rst_control.execution.event_log import Ledger
from rst_control.execution.fault_reset import Waking
from rst_control.execution.motion import Motion
from rst_control.execution.orders import (
    Change,
    DiaryEntry,
    DiaryKind,
    Order,
    Outcome,
    OutcomeKind,
    View,
)
from rst_control.execution.setpoint import STILL, Mover
from rst_control.execution.snapshot import view_of
from rst_control.planning.patient_surface import NOWHERE, TrocarPose
from rst_control.supervision.watchdogs import Watchdogs, Watched
from rst_control.types import (
    JOINT_COUNT,
    LATCHED,
    Cause,
    ControllerMode,
    Measurement,
    Reason,
    Rejected,
    Setpoint,
    State,
    Vector,
)

log = logging.getLogger("rosout.rst_control.executor")

ORDERS_PER_TICK = 4  # however many callers there are, a tick stays short
MAX_PERIODS = 5  # of the path that one late tick may catch up with


class Executor:
    """Owns the state of the controller and turns orders into set-points.

    Args:
        watchdogs: What makes it brake.
        trocar_pose: Where the tool is towards the trocar, for joint positions of shape (10,).
        mover: Moves the set-point.
        clear_fault: Asks the robot to take set-points again.
        period: Time between ticks [s].
    """

    def __init__(
        self,
        watchdogs: Watchdogs,
        trocar_pose: Callable[[Vector], TrocarPose],
        mover: Mover,
        clear_fault: Callable[[], None],
        period: float,
    ) -> None:
        self._watchdogs, self._locate = watchdogs, trocar_pose
        self._mover, self._period = mover, period
        self._now = 0.0
        self._measured: Measurement | None = None
        self._trocar_pose, self._max_rcm_error = NOWHERE, 0.0
        self._mode, self._mode_changes = ControllerMode(), 0
        self._ledger = Ledger()
        self._waking = Waking(self._cannot_wake, clear_fault, self._refuse)
        self._health: Cause | None = None
        self._heartbeat = -np.inf
        self._orders: deque[Order] = deque()
        self._stops: deque[tuple[Cause, float | None]] = deque()
        self._older = 0  # orders still waiting that came before the last stop
        self._changes: deque[Change] = deque()
        self._changed = 0  # how often what verification relies on was changed from outside
        self.view = View.at_start()

    # From any thread.

    def post(self, order: Order) -> None:
        """Hand over a verified command; the next tick answers it."""
        self._orders.append(order)

    def stop(self, cause: Cause, received: float | None = None) -> None:
        """Brake, hold and latch from the next tick on; `received` [s] is told by the diary."""
        self._stops.append((cause, received))

    def change(self, change: Change) -> None:
        """Let something that verification relies on be changed, within the next tick."""
        self._changes.append(change)

    def heartbeat(self, now: float) -> None:
        """Note that the voice node is alive."""
        self._heartbeat = now

    def note_refusal(self, command: str, cause: Cause, now: float) -> None:
        """Write a refusal into the diary."""
        self._ledger.note_refusal(now, command, cause)

    @property
    def diary(self) -> deque[DiaryEntry]:
        """What happened, oldest first; to be emptied by whoever publishes it."""
        return self._ledger.diary

    @property
    def owner(self) -> str:
        """Node that asked for the present motion and has to stay; empty: none has."""
        order = self._ledger.order
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
        self._take_measurement(measured)
        self._take_stops()
        self._take_change()
        self._take_orders()
        self._resume(self._waking.keep(now))
        motion = self._mover.motion
        velocity = self._rest() if motion is None else self._move(motion, periods)
        self.view = self._seen()
        held = self._mover.held
        return None if held is None else Setpoint(held, velocity, now)

    def crashed(self, error: Exception) -> None:
        """After a tick raised: brake along the path; where that raises too, let the robot hold."""
        cause = Cause(Reason.LOOP_ERROR, f"error in the control loop: {error!r}"[:300])
        if self._mode.cause != cause:
            log.error(cause.words, exc_info=error)
        if self._mover.motion is not None and self._mode.mode_after is not State.FAULTED:
            self._fault(cause)
        else:
            self._mover.lose()
            self._latch(state_machine.at_rest(state_machine.faulted(self._mode, cause)))
            self._end_order("failed", cause)
        self.view = self._seen()  # the tick did not come to it

    def _take_measurement(self, measured: Measurement | None) -> None:
        if measured is not None and measured is not self._measured:
            self._measured = measured
            self._watchdogs.update(measured, self._mover.held, self._mover.pulled)
            self._trocar_pose = self._locate(measured.position)
            if self._mover.motion is not None:
                self._max_rcm_error = max(self._max_rcm_error, self._trocar_pose.rcm_error)
        self._health = self._watchdogs.lost(self._now, measured)

    def _take_stops(self) -> None:
        while self._stops:
            cause, received = self._stops.popleft()
            self._note("stop_received", STOP, cause, received)
            self._waking.drop(Cause(Reason.WITHDRAWN, "stopped"))
            self._older = len(self._orders)
            self._latch(state_machine.stopped(self._mode, cause))

    def _take_change(self) -> None:
        if not self._changes:
            return
        entry = self._changes.popleft()(self._seen())
        if entry is not None:
            self._changed += 1
            self.diary.append(entry)
            if self._measured is not None:
                self._trocar_pose = self._locate(self._measured.position)

    def _take_orders(self) -> None:
        for _ in range(min(ORDERS_PER_TICK, len(self._orders))):
            order = self._orders.popleft()
            outrun = self._outrun(order)
            refusal = mode_refusal(order.command, self._mode) or outrun
            if refusal is not None:
                self._refuse(order, refusal)
            elif order.serial != self._serial and order.stale is not None:
                order.stale()
            elif order.command.role is Role.ACTIVATE:
                self._resume(self._waking.take(order, self._now))
            elif order.command.role is Role.TERMINATE:
                self._terminate(order)
            else:
                self._start(order)

    def _outrun(self, order: Order) -> Rejected | None:
        """A stop is not cleared by a "hey robot" that came before it."""
        is_older, self._older = self._older > 0, max(0, self._older - 1)
        if not is_older or order.command.role is not Role.ACTIVATE:
            return None
        return Rejected(Reason.HALTED, "stopped meanwhile; say it again")

    def _start(self, order: Order) -> None:
        lost = self._health or self._watchdogs.owner(order.owner)
        if lost is not None:
            self._refuse(order, lost)
            return
        refusal = self._mover.start(order.plan, self._now)
        if refusal is not None:
            self._refuse(order, refusal)
            return
        self._end_order("stopped", Cause(Reason.REPLACED, f'replaced by "{order.command.phrase}"'))
        if self._mode.state is not State.MOVING:
            self._max_rcm_error = self._trocar_pose.rcm_error
        self._ledger.order = order
        self._change(state_machine.started(self._mode))
        self._ledger.accept(self._now, order)
        self._note("motion_started", order.command.phrase, order.plan.words)

    def _terminate(self, order: Order) -> None:
        self._ledger.accept(self._now, order)
        order.ended(Outcome("succeeded", ""))
        self._latch(state_machine.terminated(self._mode))

    def _cannot_wake(self) -> Cause | None:
        return self._watchdogs.waking(self._now, self._measured, self._mover.motion is not None)

    def _resume(self, order: Order | None) -> None:
        if order is None:
            return
        was, measured, held = self._mode, self._measured, self._mover.held
        if (
            measured is not None
            and self._mover.motion is None
            and (held is None or self._watchdogs.following(measured, held) is not None)
        ):
            self._synchronise(measured)
        self._ledger.accept(self._now, order)
        order.ended(Outcome("succeeded", ""))
        self._change(state_machine.activated(was))
        if was.is_latched:
            self._note("cleared", order.command.phrase, was.cause or "")

    def _move(self, motion: Motion, periods: int) -> Vector:
        self._watch(motion)
        velocity = self._mover.advance(periods, self._measured, self._now)
        if motion.failure and self._mode.state is State.MOVING:
            self._latch(state_machine.failed(self._mode))
        if motion.is_done:
            self._finish(motion)
        return velocity

    def _watch(self, motion: Motion) -> None:
        if self._mode.state is State.STOPPING and self._mode.mode_after is State.FAULTED:
            return
        # Braking to a latch needs no voice: its heartbeat pauses after a stop.
        is_heard = self._ledger.is_spoken and not self._mode.is_latched
        held = self._mover.held
        watched = Watched(
            setpoint=np.zeros(JOINT_COUNT) if held is None else held,
            trocar_pose=self._trocar_pose,
            raises_tension=motion.raises_tension,
            needs_grip=motion.needs_grip,
            overtime=motion.overtime(self._now),
            heartbeat_age=self._now - self._heartbeat if is_heard else None,
            owner=self.owner,
        )
        self._fault(self._watchdogs.motion(self._now, self._measured, watched))

    def _finish(self, motion: Motion) -> None:
        was = self._mode
        self._mover.finish()
        self._change(state_machine.at_rest(was))
        if was.state is State.MOVING:
            self._note("motion_finished", self._ledger.command, f"tension {self._tension:.2f} N")
            self._end_order("succeeded", None)
            return
        ended = motion.failure or Cause(Reason.TERMINATED, "terminated")
        cause = was.cause if was.is_latched and was.cause else ended
        self._note("at_rest", self._ledger.command, cause)
        self._note_latch()
        self._end_order(
            "stopped" if was.mode_after in (State.HALTED, State.STANDBY) else "failed", cause
        )

    def _rest(self) -> Vector:
        measured = self._measured
        self._fault(self._watchdogs.master())
        lost = self._watchdogs.robot(self._now, measured)
        if lost is not None and lost.reason is not Reason.STALE:
            self._mover.lose()
            self._fault(lost)
        elif lost is None and measured is not None:
            self._keep_still(measured, self._mover.held)
        return STILL

    def _keep_still(self, measured: Measurement, held: Vector | None) -> None:
        if held is None:
            if self._watchdogs.is_at_rest(measured):
                self._synchronise(measured)
        elif self._mode.state is State.ACTIVE:
            self._fault(self._watchdogs.following(measured, held))
        if not measured.gripped:
            self._mover.drop_grasp()

    def _synchronise(self, measured: Measurement) -> None:
        """Take over where the joints are: as the robot's side says, unless they are elsewhere."""
        sent_to = measured.sent_to
        is_there = sent_to is not None and not self._watchdogs.following(measured, sent_to)
        self._mover.synchronise(measured, sent_to if is_there else None)

    @property
    def _serial(self) -> int:
        return self._mode_changes + self._mover.changes + self._changed

    @property
    def _tension(self) -> float:
        return self._measured.tension if self._measured else 0.0

    def _change(self, mode: ControllerMode) -> None:
        if mode != self._mode:
            self._mode = mode
            self._mode_changes += 1

    def _latch(self, mode: ControllerMode) -> None:
        """Take a state in which nothing moves; brake where something does."""
        was = self._mode
        is_told = was.state in LATCHED and was.cause == mode.cause
        self._change(mode)
        if not self._mover.brake() and not is_told:
            self._note_latch()

    def _fault(self, cause: Cause | None) -> None:
        if cause is not None:
            mode = state_machine.faulted(self._mode, cause)
            if mode != self._mode:
                self._latch(mode)

    def _refuse(self, order: Order, cause: Cause) -> None:
        self._ledger.refuse(self._now, order, cause, self._tension)

    def _end_order(self, kind: OutcomeKind, cause: Cause | None) -> None:
        self._ledger.end(kind, cause, self._tension, self._max_rcm_error)

    def _note(
        self, kind: DiaryKind, command: str, why: Cause | str, at: float | None = None
    ) -> None:
        words, reason = (why.words, why.reason) if isinstance(why, Cause) else (why, None)
        self._ledger.note(at or self._now, kind, command, words, reason)

    def _note_latch(self) -> None:
        if self._mode.state in LATCHED:
            self._note("halted", self._ledger.command, self._mode.cause or "")

    def _seen(self) -> View:
        return view_of(
            self._now,
            self._mode,
            self._serial,
            self._mover,
            self._ledger,
            self._trocar_pose,
            self._measured,
            self._health,
        )
