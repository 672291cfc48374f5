# SPDX-License-Identifier: BSD-3-Clause
"""Commands for a while in a plant that is not ideal, beside the ideal one.

Led by set-points; `plant_velocities.py` leads by velocities. In the ideal plant, in `lab` with a
fixed trocar, with play and friction made up for (launch/lab.yaml) and not, and with a trocar that
breathes, followed and not. RCM error is the shaft's distance from where the trocar truly is. A stop
that nobody asked for, or a command that is refused or given up, is needless: nothing is wrong. An
arm that was stopped follows no trocar until "hey robot"; those 1.4 s of every second cycle count,
too. Commands are given in pieces of a minute, which are kept.

BENCH_PLANT_SECONDS is the simulated time of each; an hour is meant. BENCH_PLANT_PLANTS names the
plants, with a | between.
"""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, replace
from functools import cache
from pathlib import Path
from textwrap import shorten
from typing import Any, Final

import numpy as np

from bench.common import resumable
from bench.common.resumable import CACHE, JOBS, carried_out, code, digest, pool
from bench.common.rig import Rig
from bench.kinova.rig import FILES, KinovaRig, kinova_motion
from bench.site.late_robot import LateRobot
from bench.site.plant_session import AnyRig, Seen, Session
from rst_control.assembly import compensated
from rst_control.config import CONFIG_FOLDER, PACKAGE, MotionConfig, load_simulation_config
from rst_control.config.plant import PlantConfig
from rst_control.kinematics.configuration import planning_joints
from rst_control.registration.trocar_following import TrocarFollowing
from support.figures import ROOT, Figure, rate, share
from typed_config import load_config, load_yaml, overlaid

SECONDS: Final = float(os.environ.get("BENCH_PLANT_SECONDS", "3600"))  # in each plant
PIECE: Final = 60.0  # [s] of one piece: each begins anew, with noise of its own
Job = tuple[int, str, str]  # number of the piece, way of leading, plant
HOUR: Final = 3600.0  # [s]
NOTE_LENGTH: Final = 160  # characters for the reasons of stops
AS_IT_IS: Final = "nothing made up for"
ALL_PLANTS: Final = (
    "ideal",
    "lab, fixed trocar",
    f"lab, fixed trocar, {AS_IT_IS}",
    "lab, breathing",
    "lab, breathing, followed",
)
REFUSED: Final = ("velocities", ALL_PLANTS[-1])  # the settings refuse to follow so late an arm
PLANTS: Final = tuple(os.environ.get("BENCH_PLANT_PLANTS", "|".join(ALL_PLANTS)).split("|"))


def measure() -> list[Figure]:
    """Figures of an arm that is led by set-points."""
    return measured("set-points")


def measured(lead: str) -> list[Figure]:
    """Of a way of leading in each plant, of the pieces that there was time for."""
    count = max(1, round(SECONDS / PIECE))
    plants = [plant for plant in PLANTS if (lead, plant) != REFUSED]
    jobs = [(job, _file(job)) for job in itertools.product(range(count), [lead], plants)]
    with pool(JOBS, _prepare) as processes:
        list(carried_out("site.plant", jobs, _one, processes))
    figures: list[Figure] = []
    seconds = {plant: 0.0 for plant in ALL_PLANTS if (lead, plant) != REFUSED}
    for plant in plants:
        files = [file for (_, _, of), file in jobs if of == plant and file.is_file()]
        pieces = [Seen(**json.loads(file.read_text(encoding="utf-8"))) for file in files]
        seconds[plant] = sum(piece.seconds for piece in pieces)
        if pieces:
            figures += figures_of(f"{lead}, {plant}", pieces, is_fixed="breathing" not in plant)
    return [resumable.measured(min(seconds.values()), "s in each plant", HOUR), *figures]


def _file(job: Job) -> Path:
    """Of one piece, by all that decides what comes of it."""
    key = digest(job, min(PIECE, SECONDS), *_conditions())
    return CACHE / "site_plant" / f"{key}.json"


@cache
def _conditions() -> tuple[str, ...]:
    """Code and settings that decide what comes of a piece."""
    bench = Path(__file__).parents[1]
    folders = PACKAGE / "src", bench / "common", bench / "kinova", bench / "site"
    files = [*sorted(CONFIG_FOLDER.glob("*.yaml")), *sorted((ROOT / "launch").glob("*lab.yaml"))]
    return *map(code, folders), *(file.read_text(encoding="utf-8") for file in files)


def _prepare() -> None:
    """Each piece makes its own rig."""


def _one(job: Job) -> dict[str, Any]:
    """What a piece of commands shows; each has noise of its own."""
    number, lead, plant = job
    with make_rig(lead, plant, number) as rig:
        return asdict(Session(rig, lead == "velocities").run(min(PIECE, SECONDS)))


def make_rig(lead: str, plant: str, number: int = 0) -> AnyRig:
    """Controller and robot, ready for "hey robot"."""
    simulation = load_simulation_config()
    seeded = replace(simulation.plant, seed=simulation.plant.seed + number)
    lab: PlantConfig | None = None if plant == "ideal" else seeded
    if lab is not None and "breathing" not in plant:
        lab = replace(lab, body_wall=replace(lab.body_wall, stroke=0.0))
    is_velocities = lead == "velocities"
    file = "kinova_lab.yaml" if is_velocities else "lab.yaml"
    site = {} if lab is None else load_yaml(ROOT / "launch" / file)
    motion = kinova_motion(site) if is_velocities else _motion(site)
    motion = _improved(motion, "followed" in plant, AS_IT_IS not in plant)
    if is_velocities:
        rig: AnyRig = KinovaRig(motion, plant=lab)
    else:
        if lab is not None:
            simulator = replace(simulation.simulator, plant="lab")
            simulation = replace(simulation, plant=lab, simulator=simulator)
        rig = Rig(motion, simulation)
        if lab is not None:
            rig.link = LateRobot(rig.robot, lab.lateness, rig.period, lab.seed)
    state = lambda: rig.executor.snapshot.mode.state  # noqa: E731
    rig.link = compensated(rig.link, motion, state)
    if "followed" in plant:
        patient = rig.planner.patient
        pose = lambda joints: patient.trocar_pose(planning_joints(joints)[0])  # noqa: E731
        rig.link = TrocarFollowing(rig.link, motion, rig.planner.model, state, pose)
    return rig


def _motion(over: Mapping[str, Any]) -> MotionConfig:
    """Settings of the controller as shipped, with some changed."""
    files = {name: load_yaml(CONFIG_FOLDER / f"{name}.yaml") for name in FILES}
    return load_config(MotionConfig, overlaid(files, over), "settings of the site")


def _improved(motion: MotionConfig, follows: bool, makes_up: bool) -> MotionConfig:
    """The settings with the trocar followed or not, play and friction made up for or not."""
    controller = motion.controller
    trocar = replace(controller.tracking.trocar, motion="followed" if follows else "fixed")
    controller = replace(controller, tracking=replace(controller.tracking, trocar=trocar))
    if not makes_up:
        controller = replace(
            controller,
            tool_play=replace(controller.tool_play, width=(0.0, 0.0)),
            joint_correction=replace(controller.joint_correction, gain=0.0),
        )
    return replace(motion, controller=controller)


def figures_of(name: str, pieces: Sequence[Seen], is_fixed: bool) -> list[Figure]:
    """Figures of one way of leading in one plant, over all pieces."""
    seen = Seen()
    for piece in pieces:
        for entry in fields(Seen):
            setattr(seen, entry.name, getattr(seen, entry.name) + getattr(piece, entry.name))
    hours = seen.seconds / HOUR
    reasons = sorted(set(seen.needless))
    listed = shorten("; ".join(reasons), NOTE_LENGTH, placeholder=" ...")
    stops = 0.0 if seen.seconds >= HOUR else None  # less shows nothing of an hour
    off = np.abs(seen.tension) if seen.tension else np.array([np.nan])
    rows = [
        ("RCM error p90", _quantile(seen.rcm, 0.90) * 1e3, "mm", None, ""),
        ("RCM error p99", _quantile(seen.rcm, 0.99) * 1e3, "mm", 0.5 if is_fixed else None, ""),
        ("RCM error max", max(seen.rcm) * 1e3, "mm", None, ""),
        ("tip off its course, p99", _quantile(seen.tip, 0.99) * 1e3, "mm", None, ""),
        ("tension error max", float(off.max()), "N", 0.1, f"({len(seen.tension)} targets)"),
        ("force on the trocar, p90", _quantile(seen.force, 0.90), "N", None, ""),
        ("force on the trocar, max", max(seen.force), "N", None, ""),
        ("stop way max", max(seen.stop_ways, default=np.nan) * 1e3, "mm", None, ""),
    ]
    figures = [rate(f"{name}: needless stops per hour", len(seen.needless), hours, stops, listed)]
    for what, value, unit, goal, note in rows:
        if not np.isnan(value):  # else nothing was seen of it
            figures.append(Figure(f"{name}: {what}", value, unit, goal, note=note))
    if grasps := len(seen.triangulated):
        failed = ", ".join(sorted({words.split(" ")[0] for words in seen.failures}))
        figures.append(share(f"{name}: triangulated", sum(seen.triangulated), grasps, note=failed))
    return figures


def _quantile(values: Sequence[float], q: float) -> float:
    return float(np.quantile(values, q))
