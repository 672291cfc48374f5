# SPDX-License-Identifier: BSD-3-Clause
"""What SIGKILL takes from a recording, and how many messages a second the writer bears."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from bench.recording import traffic
from session_log.cli import CONFIG
from session_log.config import RecorderConfig
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
from session_log.mcap_file.writer import SessionWriter
from session_log.recording.recorder import Recorder
from session_log.types import MessageSource
from support.figures import ROOT, Figure
from typed_config import load_config, load_yaml

KILLS = 200
AT_ONCE = 3  # processes under traffic at the same time
FLOOD = 200_000  # messages offered as fast as they come


@dataclass(frozen=True)
class Kill:
    """What one kill left."""

    acknowledged: int  # messages
    found: int  # messages
    missing: int  # messages, by gaps in the recorder's count
    late: float | None  # [s] from the last message in the file to the kill; None: there is none
    is_damaged: bool  # beyond the end that was cut off


def kills() -> list[Figure]:
    """Kill recorders under traffic, each at a random moment."""
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(AT_ONCE) as pool:
        folder = Path(name)
        results = list(pool.map(lambda k: _kill(folder / f"kill{k}.mcap", k), range(KILLS)))
    lost = sum(max(kill.acknowledged - kill.found, 0) + kill.missing for kill in results)
    late = [kill.late * 1e3 for kill in results if kill.late is not None]
    damaged = sum(kill.is_damaged for kill in results)
    return [
        Figure("processes killed", KILLS, "", KILLS, at_most=False, note="500 Hz x 3 and sound"),
        Figure("messages acknowledged before the kills", sum(k.acknowledged for k in results), ""),
        Figure("acknowledged messages lost", lost, "", 0.0),
        Figure("files with damage before their end", damaged, "", 0.0),
        Figure("newest message in the file older than the kill, most", max(late), "ms"),
    ]


def _kill(path: Path, seed: int) -> Kill:
    process = subprocess.Popen(
        [sys.executable, traffic.__file__, "record", str(path)],
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        cwd=ROOT,
    )
    stdout = process.stdout
    if stdout is None:
        raise RuntimeError("no output of the process under traffic")
    stdout.readline()
    time.sleep(random.Random(seed).uniform(0.05, 0.6))
    killed = time.time_ns()
    process.send_signal(signal.SIGKILL)
    lines = stdout.read().split(b"\n")[:-1]
    process.wait()
    acknowledged = max((int(line) for line in lines if line.strip()), default=0)
    found = read_summary(SessionReader(path))
    last = max((topic.last for topic in found.topics.values()), default=None)
    late = None if last is None else max(killed - last, 0) * 1e-9
    holes = [d for d in found.condition.damage if "cut off" not in d.what]
    path.unlink()
    return Kill(acknowledged, found.messages, found.missing, late, bool(holes))


def flood() -> list[Figure]:
    """Offer messages as fast as Python can, and wait until all are on disk."""
    config = load_config(RecorderConfig, load_yaml(CONFIG.with_name("recorder.yaml")))
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "flood.mcap"
        recorder = Recorder(lambda: SessionWriter(path), config, time.time_ns)
        tally = recorder.register(
            MessageSource("/t", "std_msgs/String", "992c", "string data", "/p")
        )
        recorder.start()
        began, data = time.monotonic(), bytes(traffic.SIZE)
        for _ in range(FLOOD):
            recorder.offer(tally, data)
        problem = recorder.close()
        took = time.monotonic() - began
        found = read_summary(SessionReader(path))
    note = f"({traffic.SIZE} B, without ROS) {problem}".strip()
    return [
        Figure("written without loss", FLOOD / took, "messages/s", note=note),
        Figure("lost of it", FLOOD - found.messages, "", 0.0),
    ]
