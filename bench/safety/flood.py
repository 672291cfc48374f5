# SPDX-License-Identifier: BSD-3-Clause
"""10,000 calls a second from 50 callers at once: does the control loop keep its times?

The callers send without waiting for answers. Meanwhile another caller gives a command every second.
The robot rests in standby, so nothing may move. It lasts a minute;
`BENCH_SECONDS=10 make bench ONLY=safety.flood` is shorter.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import rospy

from bench.common.resumable import measured
from bench.system.talking_system import Observer
from rst_control.srv import Command
from support.figures import ROOT, Figure, percentiles
from support.launched_system import System
from support.raw_peer import Flood, process_of, resident_memory
from support.waiting import wait_until

FULL = 60.0  # [s]
SECONDS = float(os.environ.get("BENCH_SECONDS", FULL))
CALLERS, RATE = 50, 10_000.0  # [1/s], of all together
CALLS = ("dance", "tense", "t\u0435nse", "", "x" * 150, "pull more")
SETTLE = 5.0  # [s] after the start, and after the flood, before memory is read
PERIOD = 1.0  # [s] between calls of the caller who waits for answers


def measure(seconds: float = SECONDS) -> list[Figure]:
    """Flood a controller with a simulated robot.

    Args:
        seconds: How long [s].

    Raises:
        RuntimeError: The system did not start.
    """
    with tempfile.TemporaryDirectory() as name, System(Path(name) / "launch.log", {}) as system:
        rospy.init_node("bench", anonymous=True, disable_signals=True)
        observer = Observer()
        system.launch(ROOT / "launch" / "system.launch", voice=False, record=False)
        wait_until(lambda: observer.state, "the controller's state")
        time.sleep(SETTLE)
        _flood(SETTLE)  # memory that it allocates once is no growth
        return _observe(observer, seconds)


def _observe(observer: Observer, seconds: float) -> list[Figure]:
    process = process_of("controller")
    held, quiet = resident_memory(process), _late(observer, SETTLE)
    states: set[str] = set()
    first = observer.totals()
    offered, waits = _flood(seconds, lambda: states.add(_state(observer)))
    last = observer.totals()
    time.sleep(SETTLE)
    grown = resident_memory(process) - held
    late = last.late_percent_since(first)
    note = f"({CALLERS} callers, {offered / seconds:.0f} calls/s sent for {seconds:.0f} s)"
    return [
        measured(seconds, "s", FULL),
        Figure("flood: late ticks", late, "%", 0.1, note=f"{note}; without it {quiet:.3f} %"),
        Figure("flood: lateness p99", last.lateness, "us", note="(last 10 s)"),
        Figure("flood: memory held more afterwards", grown, "MB", 20.0),
        Figure("flood: states other than standby", float(len(states - {"standby"})), "", 0.0),
        *percentiles("flood: answer to another caller", waits, "ms", {99: 250.0}),
    ]


def _flood(seconds: float, observe: Callable[[], None] = lambda: None) -> tuple[int, list[float]]:
    """Flood for a time [s]; calls sent, and waits of another caller [ms]."""
    command = rospy.ServiceProxy("rst_control/command", Command)
    waits: list[float] = []
    with Flood(CALLS, CALLERS, RATE) as flood:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            begun = time.monotonic()
            command("terminate")
            waits.append(1e3 * (time.monotonic() - begun))
            observe()
            time.sleep(PERIOD)
    return flood.offered, waits


def _late(observer: Observer, seconds: float) -> float:
    first = observer.totals()
    time.sleep(seconds)
    return observer.totals().late_percent_since(first)


def _state(observer: Observer) -> str:
    return observer.state.state if observer.state is not None else ""
