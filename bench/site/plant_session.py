# SPDX-License-Identifier: BSD-3-Clause
"""A session of commands in a plant, in lock-step, and what comes of it."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from bench.common.lockstep import do_nothing
from bench.common.rig import Rig
from bench.kinova.rig import KinovaRig
from bench.site.late_robot import LateRobot
from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.rcm import rcm_state
from rst_control.planning.plan import PhaseKind
from rst_control.registration.tracked_place import Report
from rst_control.registration.trocar_following import TrocarFollowing
from rst_control.robot.joint_correction import JointCorrection
from rst_control.robot.play_compensation import PlayCompensation
from rst_control.simulation.exposure import exposure
from rst_control.types import LATCHED, Cause, Reason

Array = NDArray[np.float64]
Link = TypeVar("Link")
AnyRig = Rig | KinovaRig
CYCLE: Final = (("tense", 1.0), ("pull more", 1.25), ("pull less", 1.0), ("release", None))
SAMPLE_EVERY: Final = 10  # steps of the physics between two samples
SETTLED: Final = 0.3  # [s] after a command, in which the tension is still measured
TRACKER_PERIOD: Final = 0.02  # [s] between two reports
TRACKER_DELAY: Final = 0.02  # [s] by which they come late
TRACKER_NOISE: Final = 1e-4  # [m] of each axis. Assumed: an optical tracker
EVERY_STOP: Final = 2  # cycles after which the way to the tissue is stopped halfway


@dataclass
class Seen:
    """What a session showed."""

    rcm: list[float] = field(default_factory=list)  # [m]
    tip: list[float] = field(default_factory=list)  # [m] from its course
    force: list[float] = field(default_factory=list)  # [N] of the shaft on the trocar
    tension: list[float] = field(default_factory=list)  # [N] off the target
    stop_ways: list[float] = field(default_factory=list)  # [m] of the tip
    triangulated: list[bool] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)  # of what is not triangulated
    needless: list[str] = field(default_factory=list)  # why
    seconds: float = 0.0


class Session:
    """Gives commands for a while and measures what comes of them.

    Args:
        rig: Controller and robot.
        has_tool: Whether the tool has to be homed first.
    """

    def __init__(self, rig: AnyRig, has_tool: bool) -> None:
        self._rig, self._has_tool, self.seen = rig, has_tool, Seen()
        self._random, self._steps = np.random.default_rng(7), itertools.count()
        self._following = _link_of(TrocarFollowing, rig.link)
        self._late = _link_of(LateRobot, rig.link)
        self._play = _link_of(PlayCompensation, rig.link)
        self._correction = _link_of(JointCorrection, rig.link)
        self._delay = rig.config.controller.tension.delay
        self._home, self._is_measuring = np.array(rig.config.scene.trocar), False
        self._reports: list[Report] = []
        self._reported = -np.inf

    def run(self, seconds: float) -> Seen:
        """Carry out cycles of commands until so much time has passed."""
        rig = self._rig
        self._pass(0.3)
        if self._has_tool and isinstance(rig, KinovaRig):
            self._homed(rig)
        self._wake()
        begun, self._is_measuring = rig.robot.now, True
        for number in itertools.count(1):
            for words, target in CYCLE:
                self._carry_out(words, target)
            if number % EVERY_STOP == 0:
                self._stop_on_the_way()
            if rig.robot.now - begun >= seconds:
                break
        self.seen.seconds = rig.robot.now - begun
        return self.seen

    def _homed(self, rig: KinovaRig) -> None:
        """Home the tool; its waiting goes by the rig's own ticks."""
        tick = rig.tick
        rig.tick = lambda each=do_nothing: tick(lambda: (self._each(), each())[0])  # type: ignore[method-assign,assignment]
        rig.home()
        rig.tick = tick  # type: ignore[method-assign]

    def _wake(self) -> None:
        for _ in range(5):
            reply = self._give("hey robot")
            self._pass(0.2)
            if reply == "":
                return
        raise RuntimeError(f'"hey robot": {reply}')

    def _carry_out(self, words: str, target: float | None) -> None:
        seen, rig = self.seen, self._rig
        why = self._give(words)
        if why:
            self._needless(f"{words}: {why}")
            return
        self._pass(SETTLED)
        if target is not None:
            seen.tension.append(float(np.linalg.norm(rig.robot.true_force)) - target)
        if words == "tense":
            scene, force = rig.config.scene, rig.robot.true_force
            held = exposure(rig.robot.tissue, scene, force)
            failures = held.failures(scene.triangulation) if held else ["nothing held"]
            seen.triangulated.append(not failures)
            seen.failures += failures

    def _needless(self, why: str) -> None:
        """Note it, and go on as a person would."""
        self.seen.needless.append(why)
        self._pass(1.0)
        if self._rig.executor.snapshot.mode.state in LATCHED:
            self._wake()
        if self._rig.robot.tissue.is_held:
            self._give("release")

    def _stop_on_the_way(self) -> None:
        rig = self._rig
        pending = rig.queue.take("tense", "bench")
        self._until(pending.reply.done)
        if not pending.reply.result(0).accepted:
            self.seen.needless.append(f"tense: {pending.reply.result(0).message}")
            return
        self._until(self._is_halfway)
        start = rig.tip
        rig.executor.stop(Cause(Reason.STOP_TOPIC, "bench"), rig.robot.now)
        self._pass(1.2)
        self.seen.stop_ways.append(float(np.linalg.norm(rig.tip - start)))
        self._wake()

    def _is_halfway(self) -> bool:
        view = self._rig.executor.snapshot
        if view.motion is None:
            return view.mode.state in LATCHED
        return view.motion.phase is PhaseKind.REACH and view.motion.progress > 0.5

    def _give(self, words: str) -> str:
        """Give a command and let it end; why it did not succeed, or an empty string."""
        pending = self._rig.queue.take(words, "bench")
        self._until(pending.ended.done)
        outcome = pending.ended.result(0)
        return "" if outcome.kind == "succeeded" else f"{outcome.kind}: {outcome.message}"

    def _until(self, done: Callable[[], bool]) -> None:
        end = self._rig.robot.now + 120.0
        while not done() and self._rig.robot.now < end:
            waiting = self._rig.queue.next(0.0)
            if waiting is not None:
                self._rig.queue.check(waiting)
            self._rig.tick(self._each)

    def _pass(self, seconds: float) -> None:
        for _ in range(round(seconds / self._rig.period)):
            self._rig.tick(self._each)

    def _each(self) -> None:
        """After each step of the physics."""
        robot = self._rig.robot
        if self._late is not None:
            self._late.deliver()
        if self._following is not None:
            self._track(self._following)
        if self._is_measuring and next(self._steps) % SAMPLE_EVERY == 0:
            q, _ = planning_joints(robot.true.position)
            self.seen.rcm.append(
                rcm_state(Configuration(self._rig.planner.model, q), self._trocar()).error
            )
            off = self._rig.tip - self._rig.tip_at(robot.target - self._added())
            self.seen.tip.append(float(np.linalg.norm(off)))
            plant = robot.plant
            force = 0.0 if plant is None else float(np.linalg.norm(plant.wall_force))
            self.seen.force.append(force)

    def _added(self) -> Array | float:
        """What was added to the controller's course to make up for play and friction [rad]."""
        added: Array | float = 0.0
        if self._play is not None:
            added = added + self._play.noted.at(self._rig.robot.now - self._delay).position
        return added if self._correction is None else added + self._correction.added

    def _trocar(self) -> Array:
        plant = self._rig.robot.plant
        return self._home if plant is None else plant.trocar

    def _track(self, following: TrocarFollowing) -> None:
        now = self._rig.robot.now
        if now - self._reported >= TRACKER_PERIOD - 1e-9:
            self._reported = now
            noise = TRACKER_NOISE * self._random.standard_normal(3)
            self._reports.append(Report(self._trocar() + noise, now))
        while self._reports and self._reports[0].stamp <= now - TRACKER_DELAY:
            following.take(self._reports.pop(0))


def _link_of(kind: type[Link], link: Any) -> Link | None:
    """One of what the controller reaches its robot by, one behind another; None: there is none."""
    while link is not None and not isinstance(link, kind):
        link = getattr(link, "_robot", None)
    return link
