# SPDX-License-Identifier: BSD-3-Clause
"""Tension of the tissue whatever its sensor does: drawn faults, commands and tissue.

Each site states the stiffest tissue that it has, and the statement is true. A sensor that reads
too little by a factor, if for one pull only, cannot be distinguished from softer tissue. There the
site leaves its gain unchecked, and the pull is bounded by distance; what scaled sensors come to
otherwise stands beside.

Pieces of the work are kept (bench/common/resumable.py). JOBS are the processes, and MINUTES after
which no more are begun. A change of the code that decides begins anew.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from bench.common import lockstep, resumable
from bench.site import held_tissue, sensors
from bench.site.held_tissue import AT_LIMIT, RATE, HeldTissue, Spring, site
from bench.site.sensors import KINDS, LOWEST, Sensor, SensorFault, draw, healthy
from rst_control.config import load_motion_config
from rst_control.types import State
from support import product_code as code
from support.figures import Figure, share
from support.product_code import identity

FULL: Final = 10_000  # situations
SITUATIONS = int(os.environ.get("BENCH_SITUATIONS", str(FULL)))
PIECE: Final = 50  # situations that are kept together
SITES: Final = (80.0, 200.0, 600.0, 1500.0, 4000.0)  # [N/m] stiffest tissue, as each states
SOFTEST: Final = 80.0  # [N/m]
COMMANDS: Final = 20  # at most, in one situation
ABOVE: Final = 1.05  # of the limit, that no tension passes
SOFT: Final = 0.2  # of the stiffness stated
PATIENCE: Final = 12.0  # [s] for a command
WAKES: Final = 0.4  # [s] that a person waits before "hey robot"
SEED: Final = 31
VOICE, SERVICE, ACTION = WAYS = "voice", "service", "action"
NAMES: Final = {VOICE: "/voice_assist", ACTION: "/client"}  # who stays while it is carried out
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
    way: str  # one of WAYS

    @property
    def said(self) -> str:
        """The command with its amount in words, as voice and service carry it."""
        if self.distance:
            return f"{self.words} {self.distance * 1e3:.4f} mm"
        return f"{self.words} {self.tension:.4f} N" if self.tension else self.words


@dataclass(frozen=True)
class TensionSituation:
    """What is drawn."""

    number: int
    stiffest: float  # [N/m] as the site states
    tissue: Spring
    is_bound: bool  # the site bounds the pull path
    fault: SensorFault
    first: float  # [N] that "tense" asks for
    steps: tuple[Step, ...]


@dataclass(frozen=True)
class TensionPeak:
    """How one situation ended."""

    number: int
    kind: str
    onset: str
    is_bound: bool
    peak: float  # [N] true
    given: int  # commands
    accepted: int
    invalid_reason: str  # why the tension was not believed at any time; empty: it was
    rate: float  # [Hz] of the controller's loop


def draw_situation(index: int) -> TensionSituation:
    """The situation of a number, always the same."""
    rng, ways = np.random.default_rng([SEED, index]), np.random.default_rng([SEED, index, 1])
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
        number=index,
        stiffest=stiffest,
        tissue=Spring(stiffness, float(slack), float(bend)),
        is_bound=fault.failure.is_scaled,
        fault=fault,
        first=float(rng.uniform(0.2, 2.0)),
        steps=tuple(_draw_step(rng, stiffness, str(ways.choice(WAYS))) for _ in range(count)),
    )


def _draw_step(rng: np.random.Generator, stiffness: float, way: str) -> Step:
    words = "pull more" if rng.random() < 0.85 else "pull less"
    by = rng.choice(["default", "tension", "distance"])
    return Step(
        words=words,
        tension=float(rng.uniform(0.05, 1.0)) if by == "tension" else 0.0,
        distance=float(rng.uniform(0.05, 1.0) / stiffness) if by == "distance" else 0.0,
        waits=float(rng.choice([-0.2, 0.0, 0.05, 0.2, 0.5])),
        way=way,
    )


def carry_out(situation: TensionSituation, rate: float = RATE) -> TensionPeak:
    """Let the commands follow each other; a latch is cleared, as a person would."""
    config = site(situation.stiffest, situation.is_bound, rate)
    sensor = Sensor(situation.fault)
    with HeldTissue(config, situation.tissue, sensor) as rig:
        rig.run(0.2)
        rig.give("hey robot")
        steps = (Step("tense", situation.first, 0.0, 0.0, ACTION), *situation.steps)
        accepted = sum(_carry_out_step(rig, step) for step in steps)
        return TensionPeak(
            situation.number,
            situation.fault.kind,
            situation.fault.onset,
            situation.is_bound,
            rig.peak,
            len(steps),
            accepted,
            rig.invalid_reason,
            rate,
        )


def judge(situation: TensionSituation) -> TensionPeak:
    """How a situation ends; one above the limit is carried out again at the product's own rate.

    The slower loop takes notice of a sensor later, so it is the worse one. The repetition counts.
    """
    controller = load_motion_config().controller
    coarse = carry_out(situation)
    if coarse.peak <= controller.tension.limit:
        return coarse
    return carry_out(situation, controller.rate)


def _carry_out_step(rig: HeldTissue, step: Step) -> bool:
    rig.run(max(0.0, step.waits))
    if rig.executor.snapshot.mode.state in (State.HALTED, State.FAULTED):
        rig.run(WAKES)
        rig.give("hey robot")
    is_spoken, owner = step.way == VOICE, NAMES.get(step.way, "")
    if step.way == ACTION:
        pending = rig.give(step.words, step.tension, step.distance, is_spoken, owner)
    else:
        pending = rig.give(step.said, is_spoken=is_spoken, owner=owner)
    if not pending.reply.result(0).accepted:
        return False
    limit = -step.waits if step.waits < 0.0 else PATIENCE
    rig.until(pending.ended.done, limit)
    return True


def measure() -> list[Figure]:
    """Carry out what is drawn, or as many as the time allows."""
    tension = load_motion_config().controller.tension
    decides = resumable.source(lockstep, held_tissue, sensors, sys.modules[__name__])
    place = resumable.CACHE / "site_tension" / resumable.digest(identity(code.SIMULATION), decides)
    jobs = [job for variant in VARIANTS for job in _pieces(variant, place)]
    found: dict[str, list[TensionPeak]] = {variant: [] for variant in VARIANTS}
    with resumable.pool(resumable.JOBS, load_motion_config) as pool:
        for file in resumable.carried_out("site.tension", jobs, _piece, pool):
            rows = json.loads(file.read_text(encoding="utf-8"))
            found[file.name.partition("_")[0]] += [TensionPeak(**row) for row in rows]
    scaled, good, drawn = (found[variant] for variant in VARIANTS)
    return [
        resumable.measured(len(drawn), "situations", FULL),
        *(_figures(drawn, ABOVE * tension.limit) if drawn else ()),
        *(_scaled(scaled, ABOVE * tension.limit / LOWEST) if scaled else ()),
        *(_good(good, tension.limit) if good else ()),
    ]


def _pieces(variant: str, place: Path) -> Iterator[tuple[tuple[str, Sequence[int]], Path]]:
    """Numbers of situations, and where their ends are kept."""
    first, step = (list(KINDS).index("scaled"), len(KINDS)) if variant == "scaled" else (0, 1)
    count = SITUATIONS if variant == "drawn" else COMPARED
    numbers = range(first, first + count * step, step)
    for begin in range(0, count, PIECE):
        piece = numbers[begin : begin + PIECE]
        yield (variant, piece), place / f"{variant}_{piece[0]}_{piece[-1]}.json"


def _piece(job: tuple[str, Sequence[int]]) -> list[dict[str, Any]]:
    variant, numbers = job
    return [asdict(judge(VARIANTS[variant](draw_situation(n)))) for n in numbers]


def _of_good_sensor(drawn: TensionSituation) -> TensionSituation:
    rng = np.random.default_rng([SEED, drawn.number, 2])
    return replace(drawn, fault=healthy(rng), is_bound=False)


VARIANTS: Final[dict[str, Callable[[TensionSituation], TensionSituation]]] = {
    "scaled": lambda drawn: replace(drawn, is_bound=False),
    "good": _of_good_sensor,
    "drawn": lambda drawn: drawn,
}


def _figures(found: Sequence[TensionPeak], limit: float) -> list[Figure]:
    above = [p for p in found if p.peak > limit]
    given, accepted = sum(p.given for p in found), sum(p.accepted for p in found)
    again = sum(p.rate != RATE for p in found)
    note = f"({given} commands, {accepted} accepted; 80 to 4000 N/m; {again} passed the limit and"
    note = f"{note} were carried out again at the product's rate, which counts)"
    figures = [
        Figure("tension, any fault of its sensor: situations", len(found), "", FULL, False, note),
        Figure(f"tension, any fault of its sensor: above {limit:.2f} N", len(above), "", 0.0),
        Figure("tension, any fault of its sensor: peak", max(p.peak for p in found), "N", limit),
    ]
    for kind in KINDS:
        peaks = [p for p in found if p.kind == kind]
        bound = sum(p.is_bound for p in peaks)
        note = f"({len(peaks)} situations{f', {bound} bounded by distance' if bound else ''})"
        figures.append(
            Figure(
                f"tension, sensor {kind}: peak", max(p.peak for p in peaks), "N", limit, note=note
            )
        )
    return figures


def _scaled(found: Sequence[TensionPeak], most: float) -> list[Figure]:
    """What a scaled sensor does where its gain is taken for checked, and is not."""
    name = "tension, sensor scaled and its gain taken for checked: peak"
    note = f"({len(found)} situations; at most the limit over the least scale, {LOWEST})"
    return [Figure(name, max(p.peak for p in found), "N", most, note=note)]


def _good(found: Sequence[TensionPeak], limit: float) -> list[Figure]:
    """The same commands with sensors that work: how often they are not believed."""
    name, figures = "tension, good sensor", list[Figure]()
    for is_usual in (True, False):
        peaks = [p for p in found if _is_usual(draw_situation(p.number)) == is_usual]
        which = "as stiff as stated, to a fifth of it" if is_usual else "softer, or slack"
        wrong, target = sum(bool(p.invalid_reason) for p in peaks), 0.0 if is_usual else None
        title = f"{name}, tissue {which}: not believed"
        figures.append(share(title, wrong, len(peaks), target, at_most=True, note="situations"))
    return [*figures, Figure(f"{name}: peak", max(p.peak for p in found), "N", limit)]


def _is_usual(drawn: TensionSituation) -> bool:
    return drawn.tissue.slack == 0.0 and drawn.tissue.stiffness >= SOFT * drawn.stiffest
