# SPDX-License-Identifier: BSD-3-Clause
"""One stretch of the soak: controller, voice and robot in lock-step, while things happen."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bench.common.rig import with_tissue
from bench.safety.soak.check import CheckedTick, Checker, SoakBounds
from bench.safety.soak.events import Chance, SoakEvent, SoakStanding
from bench.safety.soak.faults import Faults
from bench.safety.soak.robot import SensorLink, ServoRobot
from bench.safety.soak.voice import SoakVoice
from bench.system.processes import resident
from rst_control.admission.command_queue import CommandQueue, QueuedCommand
from rst_control.admission.recording_gate import RecordedOnly, RecordingWatch
from rst_control.assembly import make_executor
from rst_control.commands.parser import is_stop
from rst_control.config import (
    LimitsConfig,
    MotionConfig,
    load_motion_config,
    load_simulation_config,
)
from rst_control.execution.executor import MAX_PERIODS
from rst_control.execution.fault_reset import RESET_TIME
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.kinematics.robot_model import RobotModel, load_robot
from rst_control.registration.trocar_context import ActiveTrocarContext, TrocarContext
from rst_control.simulation.pybullet_robot import servo_limits
from rst_control.types import Cause, Reason, Setpoint, State
from voice_assist.config import load_voice_config

START = 10.0  # [s] time of the first state
BEAT = 0.1  # [s] between heartbeats of voice and recorder
PUBLISH = 0.02  # [s] between two rounds of the publisher
STIFFNESS = (20.0, 1000.0)  # [N/m] of the tissue, drawn anew for each stretch
NODES = (9, 9)  # of its sheet
STOP_TIME = 0.4  # [s] to brake; 0.06 s are enough, but tissue that pulls may add to it

LATE_TIME = 1.0  # [s] that the loop may be late by, longest; a "hey robot" waits as long


@dataclass(frozen=True)
class Stretch:
    """A piece of the soak."""

    seed: int
    seconds: float  # of session time


class SoakSession:
    """Everything of one stretch; time goes on only by `tick`.

    Args:
        stretch: Seed and length.
        model: The robot.
    """

    def __init__(self, stretch: Stretch, model: RobotModel) -> None:
        self.rng = np.random.default_rng([stretch.seed, 2026])
        config = self._settings(load_motion_config())
        simulation = load_simulation_config()
        settings = replace(simulation, scene=config.scene, limits=config.limits)
        self.period = 1.0 / config.controller.rate
        context = ActiveTrocarContext(TrocarContext(config, model))
        self.robot = ServoRobot(settings, model, START)
        self.link = SensorLink(self.robot)
        self.executor = make_executor(config, context, self.robot.clear_fault)
        self.watch = RecordingWatch(config.controller.recording, lambda: self.robot.now)
        verify = RecordedOnly(context.verify, self.watch)
        self.queue = CommandQueue(self.executor, verify, lambda: self.robot.now)
        self.voice = SoakVoice(load_voice_config().commands, self.queue, self.executor)
        self.check = Checker(make_bounds(config), context.trocar_pose)
        self.faults = Faults(self.robot, self.link, self.voice)
        self.chance, self.counts = Chance(self.rng), Counter[str]()
        self._waiting: list[tuple[int, QueuedCommand]] = []
        self._said: list[str] = []
        self._is_sending = self._was_stopped = self._was_recorded = False
        self._ticks = 0

    def _settings(self, config: MotionConfig) -> MotionConfig:
        low, high = np.log(STIFFNESS)
        stiffness = float(np.exp(self.rng.uniform(low, high)))
        on_loss = str(self.rng.choice(("refuse", "stop")))
        controller = config.controller
        recording = replace(controller.recording, on_loss=on_loss)
        controller = replace(controller, recording=recording)
        return with_tissue(replace(config, controller=controller), stiffness=stiffness, nodes=NODES)

    def run(self, seconds: float) -> None:
        """Let things happen for a time of the session [s]."""
        due = 0.5  # [s]
        for n in range(round(seconds / self.period)):
            if n * self.period >= due:
                self.happen(self.chance.event(self._standing))
                due += self.chance.gap()
            self.tick()

    def happen(self, event: SoakEvent) -> None:
        """Let one thing happen before the next tick."""
        self.counts[f"{event.kind}: {event.words if event.kind == 'fault' else ''}".rstrip()] += 1
        if event.kind in ("say", "talk"):
            self._hear(event)
        elif event.kind == "stop":
            self.stop(Cause(Reason.STOP_TOPIC, "stopped by the soak"))
        elif event.kind == "hand":
            self._note_given(event.words)
            self.queue.take(event.words, "the soak", tension=event.tension, distance=event.distance)
        else:
            self.faults.begin(event)

    def stop(self, cause: Cause) -> None:
        """Stop by the topic, a cancelled goal or the service."""
        self._was_stopped = True
        self.executor.stop(cause)

    def tick(self) -> None:
        """One period of everything."""
        self._ticks += 1
        self._beat()
        if words := self.voice.call():
            self._note_given(words)
        self._verify()
        self.faults.tick(self.robot.now)
        if not self.faults.is_late:
            self._control()
        if self._ticks % round(PUBLISH / self.period) == 0:
            self._publish()
        self.robot.advance(self.period)

    def report(self) -> dict[str, Any]:
        """For JSON."""
        return {"counts": dict(self.counts), **self.check.report()}

    @property
    def _standing(self) -> SoakStanding:
        view = self.executor.snapshot
        is_active = view.mode.is_active and self.voice.is_active
        outside = view.trocar_pose.is_outside
        return SoakStanding(is_active, view.mode.is_latched, view.is_tissue_held, outside)

    def _hear(self, event: SoakEvent) -> None:
        if not self.voice.is_alive:
            return
        said = self.voice.hear(event.words)
        if said.has_acted and said.command == "stop":
            self._was_stopped = True
        if event.kind == "talk" and said.has_acted:
            self.check.counts["talk: it did something"] += 1

    def _note_given(self, words: str) -> None:
        self._said.append(words)
        self._was_stopped |= is_stop(words)

    def _beat(self) -> None:
        if self._ticks % round(BEAT / self.period):
            return
        if self.voice.is_alive:
            self.executor.heartbeat(self.robot.now)
        if not self.faults.is_unrecorded:
            self.watch.heard("/recorder", "")

    def _verify(self) -> None:
        """As the planning thread does: one command after the other, some ticks later."""
        if (queued := self.queue.next(0.0)) is not None:
            self._waiting.append((self._ticks + self.chance.late(), queued))
        if self._waiting and self._waiting[0][0] <= self._ticks:
            self.queue.check(self._waiting.pop(0)[1])
            self._was_recorded = not self.watch.problem

    def _control(self) -> None:
        before, now = self.executor.snapshot, self.robot.now
        setpoint: Setpoint | None = None
        try:
            if self.faults.is_raising:
                raise ArithmeticError("of the soak")
            setpoint = self.executor.tick(now, self.link.measured_js())
        except Exception as error:  # as the control loop's thread does
            if not self.faults.is_raising:
                self.check.counts[f"exception: {error!r}"] += 1
            self.executor.crashed(error)
            self.faults.is_raising = False
            return
        if setpoint is not None:
            self.robot.servo_jp(setpoint)
        elif self._is_sending:
            self.robot.hold()
        self._is_sending = setpoint is not None
        self.check(self._moment(before, setpoint))
        self._said, self._was_stopped = [], False

    def _moment(self, before: ControllerSnapshot, setpoint: Setpoint | None) -> CheckedTick:
        robot = self.robot
        return CheckedTick(
            now=robot.now,
            before=before,
            after=self.executor.snapshot,
            setpoint=setpoint,
            position=robot.position,
            velocity=robot.velocity,
            tension=float(np.linalg.norm(robot.force)),
            is_servo_braking=robot.is_braking,
            was_stopped=self._was_stopped,
            said=tuple(self._said),
            is_recorded=self._was_recorded,
        )

    def _publish(self) -> None:
        """As the node's publisher: take the events, and stop what may not go on unrecorded."""
        view = self.executor.snapshot
        cause = self.watch.stop_cause(view.plan) if view.mode.state is State.MOVING else None
        if cause is not None:
            self.stop(cause)
        while self.executor.events:
            entry = self.executor.events.popleft()
            self.counts[f"event: {entry.kind}"] += 1


def make_bounds(config: MotionConfig) -> SoakBounds:
    """What may not be passed under these settings."""
    controller = config.controller
    return SoakBounds(
        joints=servo_limits(config.limits),
        acceleration=_acceleration(config.limits),
        rcm=config.rcm.measured_tolerance,
        tension=controller.tension.limit,
        stop=STOP_TIME,
        reset_time=RESET_TIME + LATE_TIME,
        period=1.0 / controller.rate,
        resting=controller.watchdogs.at_rest_speed,
        max_periods=MAX_PERIODS,
    )


def _acceleration(limits: LimitsConfig) -> np.ndarray:
    layer = limits.active
    return np.array([*layer.arm_acceleration, *[layer.tool_acceleration] * 3])


def carried_out(stretch: Stretch) -> dict[str, Any]:
    """Do one stretch; what it came to, for JSON."""
    began, worked, before = time.perf_counter(), time.process_time(), _memory()
    session = SoakSession(stretch, load_robot())
    session.run(stretch.seconds)
    wall = time.perf_counter() - began
    cpu = time.process_time() - worked
    memory = {"rss_before": before, "rss_after": _memory(), "is_later": bool(_DONE)}
    _DONE.append(stretch.seed)
    return {"seconds": stretch.seconds, "wall": wall, "cpu": cpu, **memory, **session.report()}


_DONE: list[int] = []  # seeds of the stretches that this process has carried out


def _memory() -> float:
    """Of this process, in RAM [MiB]."""
    return resident() / (1 << 20)
