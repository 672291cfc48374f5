# SPDX-License-Identifier: BSD-3-Clause
"""What running costs: processor and memory of each node, and the time until it takes a command.

Four launches, each at rest or at work for a while, under four minutes in all. BENCH_SECONDS is the
length of a stage.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from bench.common.resumable import measured
from bench.system.processes import Usage, between, usage
from bench.system.talking_system import Observer, own_master, talking, work
from bench.system.viewers import with_viewers
from support.figures import Figure
from support.launched_system import System

FULL = 15.0  # [s] of a stage
SECONDS = float(os.environ.get("BENCH_SECONDS", FULL))
TARGETS = {  # [% of a core]
    ("voice_assist", "at rest"): 15.0,
    ("recorder", "moving, recorded"): 30.0,
    ("display", "moving, recorded, page and camera"): 5.0,
}
FIRST_COMMAND = 4.0  # [s]
Work = Callable[[System, Observer], object]


def measure(seconds: float = SECONDS) -> list[Figure]:
    """Run the stages.

    Args:
        seconds: Of each [s].

    Raises:
        RuntimeError: The system did not start, or a part of it ended.
    """

    def rest(system: System, _: Observer) -> None:
        time.sleep(seconds)

    def move(system: System, observer: Observer) -> None:
        work(system, observer, seconds)

    def shown(system: System, observer: Observer) -> None:
        with_viewers(1, lambda: move(system, observer))

    launches: tuple[tuple[dict[str, Any], dict[str, Work]], ...] = (
        ({"record": False, "is_silent": True}, {"at rest": rest}),
        ({"record": False}, {"listening to talk": rest, "moving": move}),
        ({}, {"moving, recorded": move}),
        ({"display": True, "display_port": "0"}, {"moving, recorded, page and camera": shown}),
    )
    figures: list[Figure] = []
    by_hand, by_voice = list[float](), list[float]()
    with own_master() as system:
        for arguments, stages in launches:
            with talking(system, 2.0 * seconds, **arguments) as observer:
                by_hand.append(observer.first_command)
                by_voice.append(observer.first_sound)
                for stage, act in stages.items():
                    figures += _stage(stage, system, partial(act, system, observer))
    note = f"median of {len(launches)} starts"
    return [
        measured(seconds, "s of each stage", FULL),
        Figure(
            "roslaunch to the first command taken, by hand",
            float(np.median(by_hand)),
            "s",
            FIRST_COMMAND,
            note=note,
        ),
        Figure("roslaunch to hearing", float(np.median(by_voice)), "s", note=note),
        *figures,
    ]


def _stage(name: str, system: System, act: Callable[[], object]) -> Iterator[Figure]:
    first, began = usage(system.pids()), time.monotonic()
    act()
    last, took = usage(system.pids()), time.monotonic() - began
    shares = {node: 100.0 * used / took for node, used in between(first, last).items()}
    for node in sorted(shares, key=shares.__getitem__, reverse=True):
        target = TARGETS.get((node, name))
        yield Figure(f"{name}: {node}, processor", shares[node], "% of a core", target)
        yield Figure(f"{name}: {node}, memory", last[node].memory, "MB")
    whole = sum(last.values(), Usage())
    yield Figure(f"{name}: all, processor", sum(shares.values()), "% of a core")
    yield Figure(f"{name}: all, memory", whole.memory, "MB")
