# SPDX-License-Identifier: BSD-3-Clause
"""What SIGKILL takes from a recording under traffic.

`python -m bench.recording.kills FILE` is the process under traffic that is killed.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from session_log.cli import CONFIG
from session_log.config import RecorderConfig
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
from session_log.mcap_file.writer import SessionWriter
from session_log.recording.recorder import Recorder
from session_log.types import MessageSource
from support.figures import ROOT, Figure
from typed_config import load_file

KILLS = 200
AT_ONCE = 3  # processes under traffic at the same time
SIZE = 320  # [B] of a JointState with ten joints
TRAFFIC = ((SIZE, 500), (SIZE, 500), (80, 500), (1100, 31))  # [B] and [Hz]; the last is sound


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
        [sys.executable, "-m", "bench.recording.kills", str(path)],
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


def record(path: Path) -> None:
    """Record three topics of 500 Hz and sound from threads, as rospy would deliver them.

    Each line that is printed is the number of messages that the recorder says are written.
    """
    config = load_file(RecorderConfig, CONFIG.with_name("recorder.yaml"))
    recorder = Recorder(lambda: SessionWriter(path), config, time.time_ns)
    recorder.start()
    for number, (size, rate) in enumerate(TRAFFIC):
        topic = MessageSource(f"/t{number}", "std_msgs/String", "992c", "string data", "/p")
        offer = partial(recorder.offer, recorder.register(topic), bytes(size))
        threading.Thread(target=_repeat, args=(offer, 1.0 / rate), daemon=True).start()
    while True:
        time.sleep(0.01)
        print(recorder.status().written, flush=True)


def _repeat(act: Callable[[], None], period: float) -> None:
    due = time.monotonic()
    while True:
        act()
        due += period
        time.sleep(max(due - time.monotonic(), 0.0))


if __name__ == "__main__":
    record(Path(sys.argv[1]))
