# SPDX-License-Identifier: BSD-3-Clause
"""What is lost at 20 mm/s from anywhere in the workspace: does the shaft keep the trocar?

Between random poses the bridge is led by set-points as the controller sends them. Then something
fails. The shaft is measured until the arm rests. Afterwards the controller has to take "hey robot"
and "tense" without a hand on the arm.

Pieces of the work are kept (bench/common/resumable.py). JOBS are the processes, and MINUTES after
which no more are begun. A change of the code that decides begins anew.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bench.common import resumable
from bench.common.rig import random_poses
from bench.kinova import rig as rig_module
from bench.kinova.rig import KinovaRig, Loss, kinova_motion
from rst_control.errors import Infeasible
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.kinova.bridge import Lead
from rst_control.planning.planner import Planner
from rst_control.trajectory.motion_profile import MotionProfile
from rst_control.trajectory.path import Path
from rst_control.types import Cause, PathState, Reason, Setpoint
from support import product_code as code
from support.figures import Figure, share

Array = NDArray[np.float64]
FULL: Final = 200  # trials of each kind
TRIALS: Final = int(os.environ.get("BENCH_LOSSES", str(FULL)))
TURNED: Final = 0.05  # [rad] of the poses: the tip goes, so that it reaches its speed
SPEED: Final = 0.020  # [m/s]
ALMOST: Final = 0.95  # of that speed, from which a path counts
LENGTH: Final = 0.020  # [m] of a path, at least
HUNG: Final = (0.1, 0.6)  # [s] for which one lost reply holds up the driver's feedback
FROZEN: Final = (0.02, 0.6)  # [s] for which the bridge's host does nothing
STEP: Final = 0.001  # [s] of the physics
REPAIR: Final = 0.1  # [s] before and after the fault is cleared
PATIENCE: Final = 5.0  # [s] for the arm to rest once what was lost is there again
WATCHED: Final = 0.8  # [s] after the loss
EVERY: Final = 5  # trials after which the way back is tried
PIECE: Final = 50  # trials of a kind that are kept together, with a rig of their own


@dataclass(frozen=True)
class Stopped:
    """One loss."""

    speed: float  # [m/s] of the tip before
    error: float  # [m] of the shaft from the trocar, largest until rest
    way: float  # [m] that the tip still went
    way_back: str | None  # why the controller does not go on; empty: it does; None: not tried
    beside: str = ""  # why the bridge refused the next course; empty: it did not


def measure() -> list[Figure]:
    """All kinds of loss."""
    decides = resumable.source(rig_module, sys.modules[__name__])
    place = resumable.CACHE / "site_stops" / resumable.digest(code.identity(code.KINOVA), decides)
    jobs = [
        ((name, number), place / f"{index}_{number:03d}.json")
        for number in range(-(-TRIALS // PIECE))
        for index, name in enumerate(KINDS)
    ]
    found: dict[str, list[Stopped]] = {name: [] for name in KINDS}
    with resumable.pool(resumable.JOBS, kinova_motion) as pool:
        for file in resumable.carried_out("site.stops", jobs, _piece, pool):
            rows = json.loads(file.read_text(encoding="utf-8"))
            found[list(KINDS)[int(file.name[0])]] += [Stopped(**row) for row in rows]
    least = min(len(trials) for trials in found.values())
    figures = [f for name, trials in found.items() if trials for f in _figures(name, trials)]
    return [resumable.measured(least, "trials of each kind", FULL), *figures]


def _piece(job: tuple[str, int]) -> list[dict[str, Any]]:
    return [asdict(stopped) for stopped in _trials(*job)]


def _figures(name: str, found: Sequence[Stopped]) -> list[Figure]:
    speeds, errors = [s.speed * 1e3 for s in found], [s.error * 1e3 for s in found]
    note = f"({len(found)} trials, from {min(speeds):.1f} to {max(speeds):.1f} mm/s)"
    tried = [s.way_back for s in found if s.way_back is not None]
    refusals = "; ".join(sorted({words for words in tried if words}))[:200]
    beside = [s.beside for s in found if s.beside]
    return [
        Figure(f"{name}: shaft off the trocar, max", max(errors), "mm", 1.0, note=note),
        Figure(f"{name}: shaft off the trocar, p50", float(np.median(errors)), "mm"),
        Figure(f"{name}: way of the tip, max", max(s.way for s in found) * 1e3, "mm", note=note),
        share(f"{name}: goes on by voice", tried.count(""), len(tried), 100.0, note=refusals),
        Figure(
            f"{name}: bridge takes no course next",
            len(beside),
            "",
            note=f"({'; '.join(sorted(set(beside)))[:200]})" if beside else "",
        ),
    ]


def _trials(name: str, number: int) -> list[Stopped]:
    found: list[Stopped] = []
    rng = np.random.default_rng([number, *name.encode()])
    while len(found) < PIECE:
        with KinovaRig(kinova_motion()) as rig:
            rig.run(0.8)
            rig.home()
            drill = Drill(rig, rng)
            try:
                while len(found) < PIECE:
                    found.append(drill(name))
            except DoesNotSetOff as fault:
                if not found:
                    raise
                back = drill.go_on()  # as people would, after the trial before
                found[-1] = replace(found[-1], way_back=back, beside=str(fault))
    return found


class DoesNotSetOff(RuntimeError):
    """The bridge refuses the next course after the trial before; says why."""


class Course:
    """Set-points along a path at full speed, one for each period."""

    def __init__(self, planner: Planner, path: Path, opening: float, period: float) -> None:
        self._path, self._opening, self._period = path, opening, period
        self._profile = MotionProfile(PathState(0.0), planner.pace(path, SPEED).moving)
        self._profile.go_to(path.length)

    @property
    def share(self) -> float:
        """Of the path that lies behind."""
        return self._profile.state.s / self._path.length

    def __call__(self, now: float) -> Setpoint:
        """The next one, at a time [s]."""
        self._profile.step(self._period)
        point = self._path.evaluate(self._profile.state.s)
        velocity = robot_joints(point.dq * self._profile.state.speed, 0.0)
        return Setpoint(robot_joints(point.q, self._opening), velocity, now)


class Drill:
    """Leads the arm between random poses and lets something fail on the way.

    Args:
        rig: Controller, bridge and drivers.
        rng: Draws poses, places and times.
    """

    def __init__(self, rig: KinovaRig, rng: np.random.Generator) -> None:
        self._rig, self._rng = rig, rng
        self._number = 0
        self._poses = random_poses(rig.config, 4000, seed=int(rng.integers(2**31)), spread=TURNED)

    def __call__(self, name: str) -> Stopped:
        """One loss of a kind."""
        rig, course = self._rig, self._course()
        speed = self._set_off(course)
        start, errors = rig.tip, [0.0]
        restore = KINDS[name](self)
        for _ in range(round(WATCHED / rig.period)):
            rig.bridge.servo_jp(course(rig.now), rig.now)  # the controller brakes later
            for _ in range(round(rig.period / STEP)):
                rig.step()
                restore()
            errors.append(rig.rcm_error)
        way = float(np.linalg.norm(rig.tip - start))
        rig.lost = None
        self._number += 1
        if self._number % EVERY:
            self._repair()
            return Stopped(speed, max(errors), way, None)
        return Stopped(speed, max(errors), way, self.go_on())

    def _repair(self) -> None:
        """Let the arm come to rest, and clear its fault."""
        rig, end = self._rig, self._rig.now + PATIENCE
        while rig.now < end and (rig.bridge.lead is not Lead.NOBODY or not rig.bridge.measured):
            rig.step()
        for _ in range(round(REPAIR / STEP)):
            rig.step()
        rig.bridge.clear_fault(rig.now)
        for _ in range(round(REPAIR / STEP)):
            rig.step()

    def _course(self) -> Course:
        rig = self._rig
        rig.bridge.hold(rig.now)  # the controller, which holds the arm, is not asked from here on
        rig.step()  # set-points up to the hold do not count
        while (at := rig.bridge.measured) is None or at.sent_to is None:
            rig.step()
        q, opening = planning_joints(at.sent_to)  # where the controller begins, too
        return Course(rig.planner, self._path(rig.planner, q), opening, rig.period)

    def _set_off(self, course: Course) -> float:
        """Be on the way, at a random place; returns the speed [m/s]."""
        rig, place = self._rig, self._rng.uniform(0.3, 0.7)
        while course.share < place:
            rig.bridge.servo_jp(course(rig.now), rig.now)
            if fault := rig.bridge.fault(rig.now):
                raise DoesNotSetOff(fault)
            before = rig.tip
            for _ in range(round(rig.period / STEP)):
                rig.step()
        return float(np.linalg.norm(rig.tip - before)) / rig.period

    def _path(self, planner: Planner, q: Array) -> Path:
        """To a random pose, far enough to reach full speed, and on which the joints allow it."""
        while True:
            try:
                path = planner.leg(q, self._poses[self._rng.integers(len(self._poses))])
            except Infeasible:
                continue
            if path.length > LENGTH and planner.pace(path, SPEED).moving.speed >= ALMOST * SPEED:
                return path

    def go_on(self) -> str:
        """Why the controller takes no command after the fault was repaired; empty: it does."""
        rig = self._rig
        rig.run(0.3)
        rig.until(lambda: rig.bridge.lead is Lead.NOBODY, 5.0)
        reply = rig.give("hey robot").reply.result(0)
        rig.run(0.3)
        if reply.accepted:
            reply = rig.give("tense").reply.result(0)
        rig.run(0.2)
        rig.executor.stop(Cause(Reason.STOP_TOPIC, "bench"), rig.now)
        rig.run(1.0)
        rig.give("terminate")
        rig.run(0.2)
        return "" if reply.accepted else reply.message

    # Kinds of loss: each begins, and returns what has to be done at each step of the physics.

    def lose(self, what: Loss) -> Callable[[], None]:
        """Lose something until the arm rests."""
        self._rig.lost = what
        return lambda: None

    def hang(self) -> Callable[[], None]:
        """One reply of the arm is lost: its driver waits, then repeats what it had."""
        self._rig.drivers.lose_reply(float(self._rng.uniform(*HUNG)))
        return lambda: None

    def freeze(self) -> Callable[[], None]:
        """The bridge's host does nothing for a while; the guard runs on another."""
        rig = self._rig
        until, rig.lost = rig.now + float(self._rng.uniform(*FROZEN)), "bridge"

        def thaw() -> None:
            if rig.now >= until:
                rig.lost = None

        return thaw


KINDS: Final[dict[str, Callable[[Drill], Callable[[], None]]]] = {
    "feedback lost": lambda drill: drill.lose("feedback"),
    "driver hung on a lost reply": Drill.hang,
    "bridge lost": lambda drill: drill.lose("bridge"),
    "host of the bridge frozen, guard on another": Drill.freeze,
}
