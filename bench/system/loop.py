# SPDX-License-Identifier: BSD-3-Clause
"""The whole system at work: does the 500 Hz loop keep its times while the recogniser is busy?

Sixty seconds by default; `BENCH_SECONDS=600 make bench ONLY=system.loop` for the ten minutes of the
target.
"""

from __future__ import annotations

import os
from pathlib import Path

from bench.common.resumable import measured
from bench.system.talking_system import own_master, talking, work
from support.figures import Figure

FULL = 600.0  # [s]
SECONDS = float(os.environ.get("BENCH_SECONDS", "60"))
PAUSE = 1.0  # [s] between checks whether the robot rests


def measure(seconds: float = SECONDS) -> list[Figure]:
    """Run the system on continuous talk while the robot works on commands by service.

    Args:
        seconds: How long to measure [s].

    Raises:
        RuntimeError: The system did not start, or a part of it ended.
    """
    with own_master() as system, talking(system, seconds) as observer:
        first, heard, began = observer.totals(), observer.utterances, _processor_time()
        given = work(system, observer, seconds, PAUSE)
        last, heard = observer.totals(), observer.utterances - heard
        busy, idle = (b - a for a, b in zip(began, _processor_time(), strict=True))
    late = last.late_percent_since(first)
    load = 100.0 * busy / (busy + idle)
    note = f"{last.ticks - first.ticks} ticks in {seconds:.0f} s, {heard} utterances heard"
    return [
        measured(seconds, "s", FULL),
        Figure("500 Hz loop: late ticks", late, "%", 0.1, note=note),
        Figure("500 Hz loop: lateness p99", last.lateness, "us", note="last 10 s"),
        Figure("500 Hz loop: time of a tick p99", last.p99, "us", note="last 10 s"),
        Figure("all cores busy", load, "%", note=f"{given} commands by service meanwhile"),
    ]


def _processor_time() -> tuple[float, float]:
    """Busy and idle time of all cores since the machine started, in ticks of the kernel."""
    numbers = [float(word) for word in Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]
    idle = numbers[3] + numbers[4]
    return sum(numbers) - idle, idle
