# SPDX-License-Identifier: BSD-3-Clause
"""Commands for a while in a plant that is not ideal, beside the ideal one.

Led by set-points and by velocities (kinova_strict), each in the ideal plant, in `lab` with a fixed
trocar, and with one that breathes, followed and not. RCM error is the shaft's distance from where
the trocar truly is. A stop that nobody asked for, or a command that is refused or given up, is
needless: nothing is wrong. An arm that was stopped follows no trocar until "hey robot"; those
1.4 s of every second cycle count, too. BENCH_PLANT_SECONDS is the simulated time of each; an hour
is meant. BENCH_PLANT_LEADS names the ways of leading.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bench.common.resumable import CACHE, code, digest, remembered
from bench.common.rig import Rig
from bench.kinova.rig import FILES, KinovaRig, kinova_motion
from rst_control.config import CONFIG_FOLDER, PACKAGE, MotionConfig, load_simulation_config
from rst_control.config.plant import PlantConfig
from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.rcm import rcm_state
from rst_control.planning.plan import PhaseKind
from rst_control.registration.tracked_place import Report
from rst_control.registration.trocar_following import TrocarFollowing
from rst_control.simulation.exposure import exposure
from rst_control.simulation.plant import LateRobot
from rst_control.types import LATCHED, Cause, Reason
from support.figures import ROOT, Figure
from typed_config import load_config, load_yaml, overlaid

Array = NDArray[np.float64]
AnyRig = Rig | KinovaRig
SECONDS: Final = float(os.environ.get("BENCH_PLANT_SECONDS", "3600"))  # of each of the eight
PROCESSES: Final = 2
HOUR: Final = 3600.0  # [s]
CYCLE: Final = (("tense", 1.0), ("pull more", 1.25), ("pull less", 1.0), ("release", None))
ALL: Final = "set-points,velocities"
LEADS: Final = tuple(os.environ.get("BENCH_PLANT_LEADS", ALL).split(","))
PLANTS: Final = ("ideal", "lab, fixed trocar", "lab, breathing", "lab, breathing, followed")
LOOKS: Final = 5  # steps of the physics between two looks
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


def measure() -> list[Figure]:
    """All figures: each way of leading in each plant."""
    jobs = list(itertools.product(LEADS, PLANTS))
    with ProcessPoolExecutor(PROCESSES) as pool:
        return [figure for figures in pool.map(measured, jobs) for figure in figures]


def measured(job: tuple[str, str]) -> list[Figure]:
    """Figures of one way of leading in one plant; kept, so that a run may be interrupted."""
    lead, plant = job

    def carried_out() -> dict[str, Any]:
        with make_rig(lead, plant) as rig:
            return asdict(Session(rig, lead == "velocities").run(SECONDS))

    key = digest(job, SECONDS, code(PACKAGE / "src"), code(Path(__file__).parents[1] / "common"))
    seen = Seen(**remembered(CACHE / "site_plant" / f"{key}.json", carried_out))
    return figures_of(f"{lead}, {plant}", seen, is_fixed="breathing" not in plant)


def make_rig(lead: str, plant: str) -> AnyRig:
    """Controller and robot, ready for "hey robot"."""
    simulation = load_simulation_config()
    lab: PlantConfig | None = None if plant == "ideal" else simulation.plant
    if lab is not None and "breathing" not in plant:
        lab = replace(lab, body_wall=replace(lab.body_wall, stroke=0.0))
    follows = "followed" in plant
    if lead == "velocities":
        motion = _following(kinova_motion(), follows)
        rig: AnyRig = KinovaRig(motion, plant=lab)
    else:
        motion = _following(_at_site(lab), follows)
        if lab is not None:
            simulator = replace(simulation.simulator, plant="lab")
            simulation = replace(simulation, plant=lab, simulator=simulator)
        rig = Rig(motion, simulation)
        if lab is not None:
            rig.link = LateRobot(rig.robot, lab.lateness, rig.period, lab.seed)
    if follows:
        state = lambda: rig.executor.snapshot.mode.state  # noqa: E731
        rig.link = TrocarFollowing(rig.link, motion, rig.planner.model, state)
    return rig


def _at_site(lab: PlantConfig | None) -> MotionConfig:
    """Settings of the controller: where the robot is not ideal, with those of launch/lab.yaml."""
    files = {name: load_yaml(CONFIG_FOLDER / f"{name}.yaml") for name in FILES}
    if lab is not None:
        files = overlaid(files, load_yaml(ROOT / "launch" / "lab.yaml"))
    return load_config(MotionConfig, files, "settings of the site")


def _following(motion: MotionConfig, follows: bool) -> MotionConfig:
    if not follows:
        return motion
    tracking = motion.controller.tracking
    tracking = replace(tracking, trocar=replace(tracking.trocar, motion="followed"))
    return replace(motion, controller=replace(motion.controller, tracking=tracking))


class Session:
    """Gives commands for a while and looks at what comes of them.

    Args:
        rig: Controller and robot.
        has_tool: Whether the tool has to be homed first.
    """

    def __init__(self, rig: AnyRig, has_tool: bool) -> None:
        self._rig, self._has_tool, self.seen = rig, has_tool, Seen()
        self._random, self._steps = np.random.default_rng(7), itertools.count()
        following = rig.link if isinstance(rig.link, TrocarFollowing) else None
        self._following = following
        inner = following._robot if following is not None else rig.link
        self._late = inner if isinstance(inner, LateRobot) else None
        self._home, self._is_looking = np.array(rig.config.scene.trocar), False
        self._reports: list[Report] = []
        self._reported = -np.inf

    def run(self, seconds: float) -> Seen:
        """Carry out cycles of commands until so much time has passed."""
        rig = self._rig
        self._pass(0.3)
        if self._has_tool and isinstance(rig, KinovaRig):
            self._homed(rig)
        self._wake()
        begun, self._is_looking = rig.robot.now, True
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
        rig.tick = lambda each=_nothing: tick(lambda: (self._each(), each())[0])  # type: ignore[method-assign,assignment]
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
        if self._is_looking and next(self._steps) % LOOKS == 0:
            q, _ = planning_joints(robot.true.position)
            self.seen.rcm.append(
                rcm_state(Configuration(self._rig.planner.model, q), self._trocar()).error
            )
            off = self._rig.tip - self._rig.tip_at(robot.target)
            self.seen.tip.append(float(np.linalg.norm(off)))
            plant = robot.plant
            force = 0.0 if plant is None else float(np.linalg.norm(plant.wall_force))
            self.seen.force.append(force)

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


def _nothing() -> None:
    """What is done after a step where nothing is."""


def figures_of(name: str, seen: Seen, is_fixed: bool) -> list[Figure]:
    """Figures of one session."""
    hours = seen.seconds / HOUR
    reasons = sorted(set(seen.needless))
    note = f"({seen.seconds:.0f} s simulated"
    words = (
        f"{note}, {len(seen.needless)} stops{': ' if reasons else ''}{'; '.join(reasons)[:160]})"
    )
    stops = 0.0 if seen.seconds >= HOUR else None  # less shows nothing of an hour
    off = np.abs(seen.tension) if seen.tension else np.array([np.nan])
    rows = [
        ("needless stops per hour", len(seen.needless) / hours, "", stops, words),
        ("RCM error p90", _quantile(seen.rcm, 0.90) * 1e3, "mm", None, ""),
        ("RCM error p99", _quantile(seen.rcm, 0.99) * 1e3, "mm", 0.5 if is_fixed else None, ""),
        ("RCM error max", max(seen.rcm) * 1e3, "mm", None, ""),
        ("tip off its course, p99", _quantile(seen.tip, 0.99) * 1e3, "mm", None, ""),
        ("tension error max", float(off.max()), "N", 0.1, f"({len(seen.tension)} targets)"),
        ("force on the trocar, p90", _quantile(seen.force, 0.90), "N", None, ""),
        ("force on the trocar, max", max(seen.force), "N", None, ""),
        ("stop way max", max(seen.stop_ways, default=np.nan) * 1e3, "mm", None, ""),
    ]
    figures = [Figure(f"{name}: {what}", v, unit, goal, note=n) for what, v, unit, goal, n in rows]
    share = 100.0 * float(np.mean(seen.triangulated)) if seen.triangulated else float("nan")
    failed = sorted({words.split(" ")[0] for words in seen.failures})
    count = f"({len(seen.triangulated)} grasps{', failed: ' if failed else ''}{', '.join(failed)})"
    return [*figures, Figure(f"{name}: triangulated", share, "%", None, False, count)]


def _quantile(values: Sequence[float], share: float) -> float:
    return float(np.quantile(values, share))
