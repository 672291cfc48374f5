# SPDX-License-Identifier: BSD-3-Clause
"""Late ticks of the control loop in motion, without the recorder and with it, by turns."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from subprocess import PIPE

from bench.recording import watch
from bench.recording.node import Ros, end, roscore
from support.figures import ROOT, Figure

TURNS = 4  # of both, so that a change of the machine's load shows in both
SECONDS = 12.0  # [s] of each
SETTLE = 3.0  # [s] before each, for the recorder to start or end


@dataclass
class Ticks:
    """Of some seconds of the control loop."""

    total: int = 0
    late: float = 0.0  # skipped ones included


def loop() -> list[Figure]:
    """Measure both by turns while the robot works on commands by service."""
    with tempfile.TemporaryDirectory() as name, roscore(Path(name)) as ros:
        launches = [
            ros.start(["roslaunch", "--wait", str(ROOT / "launch" / f"{file}.launch"), *words])
            for file, *words in (("robot",), ("controller", "on_recording_loss:=ignore"))
        ]
        watcher = ros.start([sys.executable, watch.__file__], PIPE, PIPE)
        try:
            alone, recorded = _by_turns(ros, watcher, Path(name))
        finally:
            for process in (watcher, *reversed(launches)):
                end(process)
    return [
        Figure("late ticks of the loop, nothing recorded", *_percent(alone)),
        Figure("late ticks of the loop beside the recorder", *_percent(recorded)),
    ]


def _percent(ticks: Ticks) -> tuple[float, str]:
    return 100.0 * ticks.late / ticks.total, f"% of {ticks.total}"


def _by_turns(ros: Ros, watcher: subprocess.Popen[bytes], folder: Path) -> tuple[Ticks, Ticks]:
    alone, recorded = Ticks(), Ticks()
    _read(watcher)  # the robot works
    time.sleep(SETTLE)
    for turn in range(TURNS):
        _count(watcher, alone)
        recorder = ros.start_recorder(folder / f"turn{turn}")
        time.sleep(SETTLE)
        _count(watcher, recorded)
        end(recorder)
        time.sleep(SETTLE)
    return alone, recorded


def _count(watcher: subprocess.Popen[bytes], ticks: Ticks) -> None:
    first = _read(watcher)
    time.sleep(SECONDS)
    last = _read(watcher)
    ticks.total += last.total - first.total
    ticks.late += last.late - first.late


def _read(watcher: subprocess.Popen[bytes]) -> Ticks:
    """Ask the watcher for the loop's totals at this moment."""
    if watcher.stdin is None or watcher.stdout is None:
        raise RuntimeError("no pipes to the watcher")
    watcher.stdin.write(b"\n")
    watcher.stdin.flush()
    line = watcher.stdout.readline()
    if not line:
        raise RuntimeError("the watcher ended: the robot or the controller did not start")
    return Ticks(**json.loads(line))
