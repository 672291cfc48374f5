# SPDX-License-Identifier: BSD-3-Clause
"""Stops at random moments of every state of the controller, in lock-step with a light robot."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bench.common.rig import Rig
from bench.safety.stops.judge import JudgedStop, SetpointCourse, latency, objection, rest
from rst_control.admission.command_queue import PendingCommand
from rst_control.planning.plan import PhaseKind
from rst_control.types import Cause, Reason, Setpoint, State

Array = NDArray[np.float64]
ALLOWED = 0.4  # [s] to come to rest; 45 ms along a path (limits.yaml), jaws from full speed 0.34 s
WATCHED = 0.6  # [s] after a stop
BEFORE = 25  # set-points kept from before it
CLIENTS = 50
MANY = 0.02  # share of the moments at which as many clients stop at once: half of the stops
LOW, HIGH = 0.5, 1.5  # [N] between which pulls are kept


class StopStage:
    """A rig whose set-points are kept, and that can be brought into any state.

    Args:
        rig: Controller and robot.
        rng: Chooses moments.
    """

    def __init__(self, rig: Rig, rng: np.random.Generator) -> None:
        self.rig, self.rng = rig, rng
        self.sent: list[Setpoint | None] = []
        self.waiting: PendingCommand | None = None  # a command that is verified only after the stop
        send = rig.robot.servo_jp

        def keep(setpoint: Setpoint) -> None:
            self.sent.append(setpoint)
            send(setpoint)

        rig.robot.servo_jp = keep  # type: ignore[method-assign]

    @property
    def state(self) -> State:
        """Of the controller."""
        return self.rig.executor.snapshot.mode.state

    def ready(self, is_holding: bool | None = None) -> None:
        """At rest and active, with tissue held or not; None: as it is.

        Raises:
            RuntimeError: It cannot be brought there.
        """
        rig = self.rig
        rig.until(lambda: not rig.is_moving, limit=60.0)
        rig.run(0.02)
        reply = rig.give("hey robot").reply.result(0)
        if not reply.accepted:
            raise RuntimeError(f'"hey robot" was refused: {reply.message}')
        if is_holding is not None and is_holding != rig.executor.snapshot.is_tissue_held:
            wrong = rig.finish("tense" if is_holding else "release")
            if wrong:
                raise RuntimeError(wrong)

    def pull(self) -> None:
        """Set off with a pull that stays well within the range of tensions."""
        tension = self.rig.executor.snapshot.tension
        self.set_off("pull more" if tension < 0.5 * (LOW + HIGH) else "pull less", 0.4)

    def set_off(self, words: str, tension: float = 0.0) -> None:
        """Give a motion.

        Raises:
            RuntimeError: It was refused.
        """
        reply = self.rig.give(words, tension).reply.result(0)
        if not reply.accepted:
            raise RuntimeError(f'"{words}" was refused: {reply.message}')

    def wait(self, longest: float) -> None:
        """Let a random time pass, up to `longest` [s], while the robot moves."""
        for _ in range(int(self.rng.uniform(0.0, longest) / self.rig.period)):
            if not self.rig.is_moving:
                return
            self.rig.tick()


def _reaching(stage: StopStage) -> None:
    stage.ready(is_holding=False)
    stage.set_off("tense")
    stage.wait(4.0)


def _closing(stage: StopStage) -> None:
    stage.ready(is_holding=False)
    stage.set_off("tense")
    stage.rig.until(lambda: stage.rig.executor.snapshot.phase == PhaseKind.CLOSE.value)
    stage.wait(0.6)


def _pulling(stage: StopStage) -> None:
    stage.ready(is_holding=True)
    stage.pull()
    stage.wait(0.5)


def _retargeting(stage: StopStage) -> None:
    _pulling(stage)
    if stage.state is State.MOVING:
        stage.rig.give("pull less" if stage.rig.executor.snapshot.tension > LOW else "pull more")
        stage.wait(0.02)


def _releasing(stage: StopStage) -> None:
    stage.ready(is_holding=True)
    stage.set_off("release")
    stage.wait(2.5)


def _braking(stage: StopStage) -> None:
    _pulling(stage)
    if stage.rng.random() < 0.5:
        stage.rig.executor.stop(Cause(Reason.STOP_TOPIC, "the first of two"))
    else:
        stage.rig.give("terminate")
    stage.wait(0.05)


def _standby(stage: StopStage) -> None:
    stage.ready()
    stage.rig.give("terminate")


def _halted(stage: StopStage) -> None:
    stage.ready()
    stage.rig.executor.stop(Cause(Reason.STOP_TOPIC, "the first of two"))
    stage.rig.tick()


def _faulted(stage: StopStage) -> None:
    stage.ready()
    stage.rig.executor.crashed(ArithmeticError("made up by the bench"))
    stage.rig.tick()


def _verifying(stage: StopStage) -> None:
    """A command has come and is not verified yet, or was and waits for the tick of the stop."""
    stage.ready()
    holds = stage.rig.executor.snapshot.is_tissue_held
    stage.waiting = stage.rig.queue.take("release" if holds else "tense", "bench")
    if stage.rng.random() < 0.5:
        _verify(stage)


def _verify(stage: StopStage) -> None:
    pending = stage.rig.queue.next(0.0)
    if pending is not None:
        stage.rig.queue.check(pending)


SITUATIONS: dict[str, Callable[[StopStage], None]] = {
    "standby": _standby,
    "active": lambda stage: stage.ready(),
    "reaching": _reaching,
    "closing": _closing,
    "pulling": _pulling,
    "retargeting": _retargeting,
    "releasing": _releasing,
    "braking": _braking,
    "halted": _halted,
    "faulted": _faulted,
    "verifying": _verifying,
}


def one_stop(stage: StopStage, situation: str) -> list[JudgedStop]:
    """Bring a situation about, stop at a random moment, and watch what comes of it."""
    stage.waiting = None
    SITUATIONS[situation](stage)
    rig, rng = stage.rig, stage.rng
    clients = CLIENTS if rng.random() < MANY else 1
    if stage.waiting is None:  # else it would be carried out before the stop
        rig.run(2.0 * rig.period)
    stage.sent, old = [], stage.sent[-BEFORE:]
    received = rig.robot.now - rig.period * rng.uniform(0.0, 1.0, clients)
    rig.executor.events.clear()
    for moment in received.tolist():
        rig.executor.stop(Cause(Reason.STOP_TOPIC, "bench"), moment)
    rcm = [0.0]
    for tick in range(round(WATCHED / rig.period)):
        rig.tick(lambda: rcm.append(rig.rcm_error))
        if tick == 1:
            _verify(stage)
    noted = sum(entry.kind == "stop_received" for entry in rig.executor.events)
    course = course_of([*old, *stage.sent])
    missed = _not_latched(stage, noted, clients)
    return [
        JudgedStop(
            situation=situation,
            way="in process",
            clients=clients,
            latency=latency(course, moment),
            rest=rest(course, moment),
            rcm_error=max(rcm),
            objection=missed or objection(course, moment, ALLOWED),
        )
        for moment in received.tolist()
    ]


def _not_latched(stage: StopStage, noted: int, clients: int) -> str:
    """Why the controller itself did not obey; empty: it did."""
    if noted != clients:
        return f"{noted} of {clients} stops in the event log"
    if stage.state not in (State.HALTED, State.FAULTED):
        return f"state {stage.state.value} after the stop"
    pending, stage.waiting = stage.waiting, None
    if pending is not None and (not pending.reply.done() or pending.reply.result(0).accepted):
        return "a command that waited was carried out after the stop"
    return ""


def course_of(setpoints: list[Setpoint | None]) -> SetpointCourse:
    """Set-points as arrays; where none was sent, nothing is in it. Empty arrays where none was."""
    sent = [setpoint for setpoint in setpoints if setpoint is not None]
    if not sent:
        return SetpointCourse(np.empty(0), np.empty((0, 10)), np.empty((0, 10)))
    return SetpointCourse(
        np.array([setpoint.stamp for setpoint in sent]),
        np.array([setpoint.position for setpoint in sent]),
        np.array([setpoint.velocity for setpoint in sent]),
    )
