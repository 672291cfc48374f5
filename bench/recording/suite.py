# SPDX-License-Identifier: BSD-3-Clause
"""Recording: loss under SIGKILL, messages per second, CPU and memory, late ticks, reading, reports.

All of it takes about five minutes; `make bench ONLY=sessions.kills` is one part.
"""

from __future__ import annotations

from collections.abc import Callable

from bench.recording.kills import flood, kills
from bench.recording.loop import loop
from bench.recording.node import node
from bench.recording.read import many, reading
from support.figures import Figure

PARTS: dict[str, Callable[[], list[Figure]]] = {
    "kills": kills,
    "flood": flood,
    "node": node,
    "loop": loop,
    "reading": reading,
    "many": many,
}


def measure() -> list[Figure]:
    """Measure everything."""
    return [figure for part in PARTS.values() for figure in part()]
