# SPDX-License-Identifier: BSD-3-Clause
"""Tension of the tissue whatever its sensor does: drawn faults, commands and tissue.

Each site states the stiffest tissue that it has, and the statement is true. A sensor that reads
too little from the start by a constant factor cannot be told from softer tissue. There the site
bounds the way of the pull, too (`scene.max_displacement`); without that the peak is reported.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bench.site.held_tissue import AT_LIMIT, RATE, HeldTissue, Spring, site
from bench.site.sensors import KINDS, Sensor, SensorFault, draw, healthy
from rst_control.config import load_motion_config
from rst_control.types import State
from support.figures import Figure

SITUATIONS = int(os.environ.get("BENCH_SITUATIONS", "10000"))
PROCESSES = int(os.environ.get("BENCH_PROCESSES", "1"))
MINUTES = float(os.environ.get("BENCH_MINUTES", "60"))
SITES: Final = (80.0, 200.0, 600.0, 1500.0, 4000.0)  # [N/m] stiffest tissue, as each states
SOFTEST: Final = 80.0  # [N/m]
COMMANDS: Final = 20  # at most, in one situation
ABOVE: Final = 1.05  # of the limit, that no tension passes
SOFT: Final = 0.2  # of the stiffness stated
PATIENCE: Final = 12.0  # [s] for a command
WAKES: Final = 0.4  # [s] that a person waits before "hey robot"
SEED: Final = 31
COMPARED: Final = int(
    os.environ.get("BENCH_COMPARED", "200")
)  # situations, of scaled sensors and of good ones


@dataclass(frozen=True)
class Step:
    """One command."""

    words: str
    tension: float  # [N]; 0: as configured, or by distance
    distance: float  # [m]
    waits: float  # [s] after the one before; negative: it comes while that is under way


@dataclass(frozen=True)
class TensionSituation:
    """What is drawn."""

    stiffest: float  # [N/m] as the site states
    tissue: Spring
    is_bound: bool  # the site bounds the pull path
    fault: SensorFault
    first: float  # [N] that "tense" asks for
    steps: tuple[Step, ...]


@dataclass(frozen=True)
class TensionPeak:
    """How one situation ended."""

    kind: str
    onset: str
    is_bound: bool
    peak: float  # [N] true
    given: int  # commands
    accepted: int
    distrust: str  # why the tension was not believed at any time; empty: it was


def draw_situation(index: int) -> TensionSituation:
    """The situation of a number, always the same."""
    rng = np.random.default_rng([SEED, index])
    kind = list(KINDS)[index % len(KINDS)]
    fault = draw(rng, kind)
    stiffest = float(rng.choice(SITES))
    stiffness = stiffest
    if rng.random() < 0.7:
        stiffness = float(np.exp(rng.uniform(np.log(SOFTEST), np.log(stiffest))))
    slack = rng.uniform(0.0, 1.6 / stiffest) if rng.random() < 0.3 else 0.0
    bend = rng.uniform(0.1, 0.95) * stiffness / AT_LIMIT if rng.random() < 0.3 else 0.0
    count = int(rng.integers(1, COMMANDS + 1))
    return TensionSituation(
        stiffest=stiffest,
        tissue=Spring(stiffness, float(slack), float(bend)),
        is_bound=kind in UNKNOWABLE,
        fault=fault,
        first=float(rng.uniform(0.2, 2.0)),
        steps=tuple(_draw_step(rng, stiffness) for _ in range(count)),
    )


UNKNOWABLE: Final = ("scaled",)


def _draw_step(rng: np.random.Generator, stiffness: float) -> Step:
    words = "pull more" if rng.random() < 0.85 else "pull less"
    by = rng.choice(["default", "tension", "distance"])
    return Step(
        words=words,
        tension=float(rng.uniform(0.05, 1.0)) if by == "tension" else 0.0,
        distance=float(rng.uniform(0.05, 1.0) / stiffness) if by == "distance" else 0.0,
        waits=float(rng.choice([-0.2, 0.0, 0.05, 0.2, 0.5])),
    )


def carry_out(situation: TensionSituation, rate: float = RATE) -> TensionPeak:
    """Let the commands follow each other; a latch is cleared, as a person would."""
    config = site(situation.stiffest, situation.is_bound, rate)
    sensor = Sensor(situation.fault)
    with HeldTissue(config, situation.tissue, sensor) as rig:
        rig.run(0.2)
        rig.give("hey robot")
        steps = (Step("tense", situation.first, 0.0, 0.0), *situation.steps)
        accepted = sum(_carry_out_step(rig, step) for step in steps)
        return TensionPeak(
            situation.fault.kind,
            situation.fault.onset,
            situation.is_bound,
            rig.peak,
            len(steps),
            accepted,
            rig.distrust,
        )


def _carry_out_step(rig: HeldTissue, step: Step) -> bool:
    rig.run(max(0.0, step.waits))
    if rig.executor.snapshot.mode.state in (State.HALTED, State.FAULTED):
        rig.run(WAKES)
        rig.give("hey robot")
    pending = rig.give(step.words, step.tension, step.distance)
    if not pending.reply.result(0).accepted:
        return False
    limit = -step.waits if step.waits < 0.0 else PATIENCE
    rig.until(pending.ended.done, limit)
    return True


def measure() -> list[Figure]:
    """Carry out what is drawn, or as many as the time allows."""
    limit = ABOVE * load_motion_config().controller.tension.limit
    numbers, found = list(range(SITUATIONS)), list[TensionPeak]()
    until = time.monotonic() + 60.0 * MINUTES
    with ProcessPoolExecutor(PROCESSES, multiprocessing.get_context("spawn")) as pool:
        while numbers and time.monotonic() < until:
            now, numbers = numbers[: 40 * PROCESSES], numbers[40 * PROCESSES :]
            found += pool.map(_carry_out_number, now, chunksize=10)
    return [*_figures(found, limit), *_unbound(), *_healthy(limit)]


def _carry_out_number(index: int) -> TensionPeak:
    return carry_out(draw_situation(index))


def _figures(found: Sequence[TensionPeak], limit: float) -> list[Figure]:
    above = [p for p in found if p.peak > limit]
    given, accepted = sum(p.given for p in found), sum(p.accepted for p in found)
    note = f"({given} commands, {accepted} accepted; 80 to 4000 N/m)"
    figures = [
        Figure("tension, any fault of its sensor: situations", len(found), "", 10000, False, note),
        Figure(f"tension, any fault of its sensor: above {limit:.2f} N", len(above), "", 0.0),
        Figure("tension, any fault of its sensor: peak", max(p.peak for p in found), "N", limit),
    ]
    for kind in KINDS:
        peaks = [p for p in found if p.kind == kind]
        note = f"({len(peaks)} situations{', pull path bounded' if kind in UNKNOWABLE else ''})"
        figures.append(
            Figure(
                f"tension, sensor {kind}: peak", max(p.peak for p in peaks), "N", limit, note=note
            )
        )
    return figures


def _unbound() -> list[Figure]:
    """What a scaled sensor does where the site leaves the pull path at its full length."""
    first = list(KINDS).index("scaled")
    drawn = (draw_situation(first + i * len(KINDS)) for i in range(COMPARED))
    peaks = [carry_out(replace(s, is_bound=False)).peak for s in drawn]
    note = f"({COMPARED} situations; not bounded by the site, and cannot be known)"
    return [Figure("tension, sensor scaled, path of 30 mm: peak", max(peaks), "N", note=note)]


def _healthy(limit: float) -> list[Figure]:
    """The same commands with sensors that work: how often they are not believed."""
    rng, found = np.random.default_rng(SEED), dict[bool, list[TensionPeak]]({True: [], False: []})
    for index in range(COMPARED):
        drawn = replace(draw_situation(index), fault=healthy(rng), is_bound=False)
        is_usual = drawn.tissue.slack == 0.0 and drawn.tissue.stiffness >= SOFT * drawn.stiffest
        found[is_usual].append(carry_out(drawn))
    name, figures = "tension, good sensor", list[Figure]()
    for is_usual, peaks in found.items():
        which = "as stiff as stated, to a fifth of it" if is_usual else "softer, or slack"
        wrong = 100.0 * sum(bool(p.distrust) for p in peaks) / len(peaks)
        target, note = (0.0 if is_usual else None), f"({len(peaks)} situations)"
        figures.append(
            Figure(f"{name}, tissue {which}: not believed", wrong, "%", target, note=note)
        )
    highest = max(p.peak for peaks in found.values() for p in peaks)
    return [*figures, Figure(f"{name}: peak", highest, "N", limit)]
