# SPDX-License-Identifier: BSD-3-Clause
"""Figures of safety, part by part; `make bench ONLY=safety.soak` measures one part.

A part is a module of this package with a function `measure`; its name in `NAMES` is all it takes.
It is imported when it is measured, so that no part needs what only another one does. Parts take
from minutes to a day, so `make bench ONLY=safety` measures none: it gathers what was measured last.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import partial

from bench.safety.summary import gather
from support.figures import RESULTS, Figure

__all__ = ["PARTS", "measure"]

NAMES = (
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

MODULES = {  # of the parts that are no folder of their own
    "hang": "bench.safety.hang",
    "flood": "bench.safety.flood",
    "stops_system": "bench.safety.stops.system",
}


def _measure(name: str) -> list[Figure]:
    module = importlib.import_module(MODULES.get(name, f"bench.safety.{name}.suite"))
    measure: Callable[[], list[Figure]] = module.measure
    return measure()


PARTS: dict[str, Callable[[], list[Figure]]] = {name: partial(_measure, name) for name in NAMES}


def measure() -> list[Figure]:
    """What was last measured of all parts, each with its date, code and load."""
    return gather(RESULTS / "safety", NAMES)
