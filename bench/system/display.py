# SPDX-License-Identifier: BSD-3-Clause
"""What the operator's page costs: its share of a core, and the control loop's late ticks.

The whole simulated system works on commands while nobody, one viewer and ten viewers look.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass

from bench.common.resumable import measured
from bench.system.processes import between, usage
from bench.system.talking_system import Loop, Observer, own_master, talking, work
from bench.system.viewers import with_viewers
from support.figures import Figure
from support.launched_system import System

STAGES = (0, 1, 10, 0, 1, 10)  # viewers; twice, as other work on the machine comes and goes
FULL = 120.0  # [s] over all stages
SECONDS = float(os.environ.get("BENCH_SECONDS", FULL))
CORE_LIMIT = 5.0  # [%] of one core


@dataclass(frozen=True)
class Stage:
    """What was seen while so many looked."""

    viewers: int
    page: float  # [%] of a core, of the page's node
    first: Loop
    last: Loop


def measure(seconds: float = SECONDS) -> list[Figure]:
    """Run the system with viewers that come and go.

    Args:
        seconds: Over all stages [s].

    Raises:
        RuntimeError: The system did not start, or a part of it ended.
    """
    with (
        own_master() as system,
        talking(system, seconds, display=True, display_port="0") as observer,
    ):
        length = seconds / len(STAGES)
        stages = [_watch(n, length, system, observer) for n in STAGES]
    return [measured(seconds, "s", FULL), *_figures(stages)]


def _figures(stages: Sequence[Stage]) -> list[Figure]:
    figures = []
    for viewers in sorted(set(STAGES)):
        mine = [stage for stage in stages if stage.viewers == viewers]
        words = f"{viewers or 'no'} viewer{'s' * (viewers != 1)}"
        page = sum(stage.page for stage in mine) / len(mine)
        ticks = sum(stage.last.ticks - stage.first.ticks for stage in mine)
        late = 100.0 * sum(stage.last.late - stage.first.late for stage in mine) / max(1, ticks)
        limit = CORE_LIMIT if viewers == 1 else None
        figures += [
            Figure(f"page's node, {words}", page, "% of a core", limit),
            Figure(f"500 Hz loop: late ticks, {words}", late, "%", note=f"({ticks} ticks)"),
        ]
    return figures


def _watch(viewers: int, seconds: float, system: System, observer: Observer) -> Stage:
    seen: list[Stage] = []

    def act() -> None:
        first, used, began = observer.totals(), usage(system.pids()), time.monotonic()
        work(system, observer, seconds)
        last, took = observer.totals(), time.monotonic() - began
        share = 100.0 * between(used, usage(system.pids()))["display"] / took
        seen.append(Stage(viewers, share, first, last))

    with_viewers(viewers, act)
    return seen[0]
