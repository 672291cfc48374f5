# SPDX-License-Identifier: BSD-3-Clause
"""Figures of safety, part by part; `make bench ONLY=safety.soak` measures one part.

A part is a module of this package with a function `measure`; its name in `NAMES` is all it takes.
It is imported when it is measured, so that no part needs what only another one does. Parts take
from minutes to a day, so `make bench ONLY=safety` measures none: it gathers what was measured last.
"""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from support.figures import RESULTS, Figure

NAMES = (
    "ends",  # Ctrl-C at moments of the start and after it
    "hang",  # a recogniser that hangs, and a machine that is busy
    "flood",  # a minute of 10,000 calls a second
    "network",  # voice on one host, controller on another, and a bad network between them
    "losses",  # each part of the running system killed or stopped in mid-motion
    "soak",  # a day of commands, talk and faults, in process
    "sound",  # an hour of sound that is none, and a "stop" after each minute of it
    "spoken",  # from the end of a spoken "stop" to the robot at rest, in the running system
    "stops",  # 10,000 stops at random moments of every state, in process
    "stops_system",  # the same in the running system, by service, topic and cancel, 50 clients
)

MODULES = {  # of the parts that are not the suite of a folder
    "ends": "ends",
    "hang": "hang",
    "flood": "flood",
    "stops_system": "stops.system",
}


def _measure(name: str) -> list[Figure]:
    module = importlib.import_module(f"bench.safety.{MODULES.get(name, f'{name}.suite')}")
    measure: Callable[[], list[Figure]] = module.measure
    return measure()


PARTS: dict[str, Callable[[], list[Figure]]] = {name: partial(_measure, name) for name in NAMES}


def measure() -> list[Figure]:
    """What was last measured of all parts, each with its date, code and load."""
    return gather(RESULTS / "safety", NAMES)


def gather(folder: Path, parts: Sequence[str]) -> list[Figure]:
    """Figures of all parts; a part that was never measured misses a target.

    Args:
        folder: With one file for each part that was measured.
        parts: Their names.
    """
    found: list[Figure] = []
    for part in parts:
        path = folder / f"{part}.json"
        if path.is_file():
            found += _on_file(part, json.loads(path.read_text(encoding="utf-8")))
        else:
            found.append(_was_measured(part, 0.0, "(never)"))
    return found


def _on_file(part: str, result: dict[str, Any]) -> list[Figure]:
    where = result["machine"]
    words = f"({where['date']}, {where['commit']}, load {where['load_at_start']})"
    figures = [_was_measured(part, 1.0, words)]
    for fields in result["figures"]:
        kept = {key: value for key, value in fields.items() if key != "met"}
        figures.append(Figure(**{**kept, "name": f"{part}: {kept['name']}"}))
    return figures


def _was_measured(part: str, value: float, words: str) -> Figure:
    return Figure(f"{part}: was measured", value, "", 1.0, at_most=False, note=words)
