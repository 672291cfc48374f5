# SPDX-License-Identifier: BSD-3-Clause
"""Insertion from anywhere and withdrawal: what can be planned, how fast, and how it is carried out.

Starts are drawn all over the joint ranges, several turns included, and kept where nothing touches
and the whole robot is outside the patient.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.common.rig import Rig
from bench.motion.bullet.witness import BulletWitness, Sight
from rst_control.commands.request import Request, Situation
from rst_control.commands.table import COMMANDS
from rst_control.commands.verifier import Verifier
from rst_control.config import MotionConfig, SimulationConfig
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.rcm import rcm_error_vector
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.planning.planner import Planner
from rst_control.trajectory.motion_profile import MotionBounds, MotionProfile
from rst_control.trajectory.path import Path
from rst_control.types import ControllerMode, Measurement, PathState, Rejected, State
from support.figures import Figure

Array = NDArray[np.float64]
NOW = 100.0  # [s]
SAMPLES = 100  # places of each phase that PyBullet is asked about
RATE = 10_000.0  # [Hz] of the samples of the way through the trocar, each checked once
RCM_WORST = 1e-6  # [m] of a planned path
FLOAT_NOISE = 1e-6  # [m] of PyBullet's poses, which have single precision
ROUNDING = 1e-3  # share by which finite differences may exceed a limit
EXECUTED = 4  # of the starts, that are carried out in PyBullet


def measure(config: MotionConfig, simulation: SimulationConfig, count: int) -> list[Figure]:
    """Plan from random starts, judge every plan by PyBullet's kinematics, carry some out.

    Args:
        config: Settings of planning.
        simulation: Settings of the simulated robot.
        count: Random starts.
    """
    planner = Planner(load_robot(), config)
    verify = Verifier(planner)
    verify.warm_up()
    times, refusals, objections, plans = [], Counter[str](), Counter[str](), []
    with BulletWitness(config) as witness:
        judge = InsertionJudge(planner, witness)
        for q in outside_starts(planner, count, seed=7):
            begin = time.perf_counter()
            decision = verify(Request(COMMANDS["insert"]), situation(q))
            times.append(time.perf_counter() - begin)
            if isinstance(decision, Rejected):
                refusals[decision.reason.value] += 1
                continue
            plans.append(decision)
            objections[judge.objection(q, decision.plan.phases, SAMPLES)] += 1
        worst = judge.worst_inside(plans[0].plan.phases, RATE) if plans else float("nan")
    starts = outside_starts(planner, min(EXECUTED, count), seed=8)
    seen = [carry_out(config, simulation, q) for q in starts]
    bad = sum(n for words, n in objections.items() if words)
    words = ", ".join(f"{n} {reason}" for reason, n in refusals.items()) or "none"
    note = f"({count} random starts; refused: {words})"
    by = f"(PyBullet's kinematics, {SAMPLES} places of each phase)"
    slow = "(PyBullet's kinematics at 10 kHz, of the way in, which all starts share)"
    ran = f"(1 kHz, {len(seen)} starts: insert, tense, release, withdraw)"
    failed = [run.failure for run in seen if run.failure]
    return [
        Figure("insertion: starts planned", 100.0 * len(plans) / count, "%", note=note),
        Figure("insertion: planning time p50", float(np.percentile(times, 50)) * 1e3, "ms"),
        Figure("insertion: planning time p99", float(np.percentile(times, 99)) * 1e3, "ms", 1000.0),
        Figure("insertion: plans that an oracle objects to", float(bad), "", 0.0, note=by),
        Figure("insertion: planned RCM error max, inside", worst * 1e6, "um", 1.0, note=slow),
        Figure("insertion: runs that failed", float(len(failed)), "", 0.0, note=", ".join(failed)),
        Figure(
            "insertion: executed RCM error max, inside",
            max(run.error for run in seen) * 1e6,
            "um",
            10.0,
            note=ran,
        ),
    ]


ACTIVE = ControllerMode(State.ACTIVE, is_active=True)


def outside_starts(planner: Planner, count: int, seed: int) -> Iterator[Array]:
    """Random joints (9,) [rad] at which nothing touches and the robot is outside the patient.

    Endless joints are within half a turn, as the arm's driver reports them.
    """
    rng, limits, outside = np.random.default_rng(seed), planner.limits, planner.patient.outside
    most = np.where(limits.endless, np.pi, np.inf)
    lower, upper = np.maximum(limits.lower, -most), np.minimum(limits.upper, most)
    made = 0
    while made < count:
        q = rng.uniform(lower, upper)
        found = outside.clearance(q)
        if found.distance >= found.allowed:
            made += 1
            yield q


def situation(q: Array, **more: bool) -> Situation:
    """An active controller on a robot at rest at q (9,) [rad], jaws closed."""
    joints, still = robot_joints(q, 0.0), np.zeros(10)
    measured = Measurement(joints, still, still, NOW, **more)
    return Situation(measured, NOW, setpoint=joints, mode=ACTIVE)


class InsertionJudge:
    """Judges plans by PyBullet's kinematics.

    Args:
        planner: Its limits are what plans have to keep.
        witness: The robot's kinematics.
    """

    def __init__(self, planner: Planner, witness: BulletWitness) -> None:
        self._planner, self._witness = planner, witness
        self._margin = planner.config.scene.surface_margin
        self._min_insertion = planner.config.rcm.insertion[0]
        self._approved: set[Path] = set()  # the way in is the same for every approach

    def objection(self, q: Array, phases: tuple[Phase, ...], samples: int) -> str:
        """What is wrong with a plan from q (9,) [rad]; empty: nothing."""
        for phase in phases:
            if phase.path is None:
                continue
            name = phase.kind.value
            if np.abs(phase.path.start - q).max() > 1e-9:
                return f"{name} begins away from where the last phase ends"
            q = phase.path.end
            if phase.path in self._approved:
                continue
            if words := self._limits(phase):
                return f"{name}: {words}"
            for s in np.linspace(0.0, phase.path.length, samples):
                place = phase.path.evaluate(s).q
                sight = self._witness.observe(place)
                if words := self._place(phase.kind, place, sight):
                    return f"{name} at {s * 1e3:.1f} mm: {words}"
            self._approved.add(phase.path)
        return ""

    def worst_inside(self, phases: tuple[Phase, ...], rate: float) -> float:
        """Largest RCM error [m] at all samples [Hz] at which the tip is in the trocar."""
        worst = 0.0
        for phase in phases:
            if phase.path is None or phase.kind is PhaseKind.APPROACH:
                continue
            profile = self._profile(phase)
            for _ in range(int(profile.remaining * rate) + 1):
                sight = self._witness.observe(phase.path.evaluate(profile.step(1.0 / rate).s).q)
                if sight.tip >= 0.0:
                    worst = max(worst, sight.error)
        return worst

    def _place(self, kind: PhaseKind, q: Array, sight: Sight) -> str:
        if self._planner.limits.violation(q) is not None:
            return "beyond a joint limit"
        if sight.arm < self._margin - FLOAT_NOISE:
            return f"arm {sight.arm * 1e3:.2f} mm from the patient's surface"
        is_clear = sight.tool >= self._margin - FLOAT_NOISE
        if kind is PhaseKind.APPROACH:
            return "" if is_clear else f"tool {sight.tool * 1e3:.2f} mm from the surface"
        if sight.error > RCM_WORST + FLOAT_NOISE:
            return f"shaft {sight.error * 1e6:.2f} um off the trocar"
        is_bent = np.abs(q[7:]).max() > 1e-9
        return (
            "bent in the trocar"
            if is_bent and sight.wrist < self._min_insertion - FLOAT_NOISE
            else ""
        )

    def _limits(self, phase: Phase) -> str:
        """Speeds and accelerations of the joints, by finite differences of the motion in time."""
        assert phase.path is not None
        profile, dt = self._profile(phase), 1.0 / self._planner.config.controller.rate
        count = int(profile.remaining / dt) + 2
        q = np.array([phase.path.evaluate(profile.step(dt).s).q for _ in range(count)])
        speed = np.abs(np.diff(q, axis=0)).max(axis=0) / dt
        pull = np.abs(np.diff(q, 2, axis=0)).max(axis=0) / dt**2
        limits = self._planner.limits
        if (speed > limits.velocity * (1.0 + ROUNDING)).any():
            return "a joint too fast"
        return "a joint too hard" if (pull > limits.acceleration * (1.0 + ROUNDING)).any() else ""

    def _profile(self, phase: Phase) -> MotionProfile:
        jerk = self._planner.config.controller.speed.jerk
        profile = MotionProfile(PathState(0.0), MotionBounds(phase.speed, phase.acceleration, jerk))
        profile.go_to(phase.target)
        return profile


class InsertionRun:
    """One session in PyBullet, checked after every step of the physics.

    Args:
        rig: At the start.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self.error = 0.0  # [m] largest distance of the shaft from the trocar with the tip inside
        self.failure = ""
        self.phases: set[str] = set()

    def finish(self, words: str) -> None:
        """Carry out one command, unless an earlier one failed."""
        if self.failure:
            return
        pending = self._rig.give(words)
        if not pending.reply.result(0).accepted:
            self.failure = f'"{words}" refused: {pending.reply.result(0).message}'
            return
        while not pending.ended.done():
            self._rig.tick(self._check)
            self.phases.add(self._rig.executor.snapshot.phase)
        if pending.ended.result(0).kind != "succeeded":
            self.failure = f'"{words}": {pending.ended.result(0).message}'

    def _check(self) -> None:
        tip, trocar = self._rig.robot.tip, self._rig.planner.trocar
        if (tip - trocar) @ self._rig.planner.patient.outward > 0.0:
            return  # the tip is outside the patient
        first, second = self._rig.robot.shaft()
        along = (second - first) / np.linalg.norm(second - first)
        self.error = max(self.error, float(np.linalg.norm(rcm_error_vector(first, along, trocar))))


def carry_out(config: MotionConfig, simulation: SimulationConfig, q: Array) -> InsertionRun:
    """Start at q (9,) [rad], then insert, tense, release and withdraw."""
    settings = replace(simulation.simulator, start_position=tuple(float(v) for v in q))
    with Rig(config, replace(simulation, simulator=settings)) as rig:
        rig.wake()
        run = InsertionRun(rig)
        for words in ("insert", "tense", "release", "withdraw"):
            run.finish(words)
        return run
