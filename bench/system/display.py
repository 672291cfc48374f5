# SPDX-License-Identifier: BSD-3-Clause
"""What the operator's page costs: its share of a core, and the control loop's late ticks.

The whole simulated system works on commands while nobody, one viewer and ten viewers look.
"""

from __future__ import annotations

import asyncio
import json
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import rosgraph
import rosnode
import rospy
from aiohttp import ClientSession, ClientTimeout

from bench.common.resumable import measured
from bench.system.talking_system import Loop, Observer, talking_system, work
from support.figures import Figure
from support.launched_system import System
from support.waiting import wait_until

STAGES = (0, 1, 10, 0, 1, 10)  # viewers; twice, as other work on the machine comes and goes
FULL = 120.0  # [s] over all stages
SECONDS = float(os.environ.get("BENCH_SECONDS", FULL))
TICKS = os.sysconf("SC_CLK_TCK")
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
    with talking_system(seconds, display=True, display_port="0") as (system, observer):
        page = str(wait_until(lambda: rospy.get_param("/display/page", ""), "the page"))
        length = seconds / len(STAGES)
        stages = [asyncio.run(_watch(page, n, length, system, observer)) for n in STAGES]
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


async def _watch(
    page: str, viewers: int, seconds: float, system: System, observer: Observer
) -> Stage:
    looking = [asyncio.create_task(_view(page)) for _ in range(viewers)]
    working = asyncio.create_task(asyncio.to_thread(work, system, observer, 1.0 + seconds))
    await asyncio.sleep(1.0)  # all are connected
    node = _pid("/display")
    first, worked, began = observer.totals(), _processor_time(node), time.monotonic()
    await working
    last, took = observer.totals(), time.monotonic() - began
    share = 100.0 * (_processor_time(node) - worked) / took
    for viewer in looking:
        viewer.cancel()
    await asyncio.gather(*looking, return_exceptions=True)
    return Stage(viewers, share, first, last)


async def _view(page: str) -> None:
    """As the page does: take every event, and fetch every picture once."""
    shown = 0
    async with (
        ClientSession(timeout=ClientTimeout()) as session,
        session.get(f"{page}/events") as events,
    ):
        async for line in events.content:
            if not line.startswith(b"data:"):
                continue
            picture = json.loads(line.removeprefix(b"data:"))["picture"]
            if picture and picture["number"] != shown:
                shown = picture["number"]
                async with session.get(f"{page}/picture") as answer:
                    await answer.read()


def _pid(node: str) -> int:
    address = rosnode.get_api_uri(rosgraph.Master("/bench"), node)
    (_, _, pid) = rosnode.ServerProxy(address).getPid("/bench")
    return int(pid)


def _processor_time(pid: int) -> float:
    """User and system time of a process [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS
