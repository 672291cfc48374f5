# SPDX-License-Identifier: BSD-3-Clause
"""Recording: loss under SIGKILL, messages per second, CPU and memory, late ticks, reading, reports.

All of it takes about five minutes; `make bench ONLY=sessions.kills` is one part.
"""

from __future__ import annotations

from collections.abc import Callable

from bench.figures import Figure
from bench.sessions_kills import flood, kills
from bench.sessions_loop import loop
from bench.sessions_node import node
from bench.sessions_read import many, reading

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
