# SPDX-License-Identifier: BSD-3-Clause
"""Recording: messages per second, and the time to read and report."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TypeVar

from session_log.cli import CONFIG
from session_log.config import RecorderConfig, ReportConfig
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
from session_log.mcap_file.writer import SessionWriter
from session_log.recording.recorder import Recorder
from session_log.report.one_session import write_report
from session_log.types import Message, MessageSource
from support.figures import Figure
from support.story import COMMIT, Story
from support.story_script import END
from typed_config import load_file

SIZE = 320  # [B] of a JointState with ten joints
FLOOD = 200_000  # messages offered as fast as they come
TURNS = 6  # of the story in one recording
READ = """
import resource, sys
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
read_summary(SessionReader(sys.argv[1]))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""

T = TypeVar("T")


def flood() -> list[Figure]:
    """Offer messages as fast as Python can, and wait until all are on disk."""
    config = load_file(RecorderConfig, CONFIG.with_name("recorder.yaml"))
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "flood.mcap"
        recorder = Recorder(lambda: SessionWriter(path), config, time.time_ns)
        tally = recorder.register(
            MessageSource("/t", "std_msgs/String", "992c", "string data", "/p")
        )
        recorder.start()
        began, data = time.monotonic(), bytes(SIZE)
        for _ in range(FLOOD):
            recorder.offer(tally, data)
        problem = recorder.close()
        took = time.monotonic() - began
        found = read_summary(SessionReader(path))
    note = f"({SIZE} B, without ROS) {problem}".strip()
    return [
        Figure("written without loss", FLOOD / took, "messages/s", note=note),
        Figure("lost of it", FLOOD - found.messages, "", 0.0),
    ]


def reading() -> list[Figure]:
    """Read and report recordings of a few minutes."""
    report_config = load_file(ReportConfig, CONFIG)
    with tempfile.TemporaryDirectory() as name:
        files = ("long.mcap", "short.mcap", "double.mcap", "out")
        path, short, double, out = (Path(name) / file for file in files)
        write_long(path, TURNS)
        write_long(short, 1)
        write_long(double, 2 * TURNS)
        size = path.stat().st_size
        grown = (_peak_of_reading(path) - _peak_of_reading(short)) / 1e6
        read, found = _timed(lambda: read_summary(SessionReader(path)))
        once, twice = (
            _processor(partial(write_report, SessionReader(file), out, report_config))
            for file in (path, double)
        )
    if found.condition.damage or found.condition.checksum != "good":
        raise RuntimeError(f"a recording of our own is read as damaged: {found.condition.damage}")
    hours = found.duration / 3600.0
    report = once + (1.0 / hours - 1.0) * (twice - once)  # a part of it is the same for any length
    note = f"(from {found.duration:.0f} s)"
    from_both = f"(of processor, from {found.duration:.0f} s and twice as long)"
    return [
        Figure("messages read", found.messages / read, "messages/s"),
        Figure("recording read", size / read / 1e6, "MB/s", note=f"({size / 1e6:.0f} MB)"),
        Figure(f"memory: {TURNS} times as long a file takes", grown, "MB more", 5.0),
        Figure("size of an hour of session", size / hours / 1e9, "GB", note=note),
        Figure("report of an hour of session", report, "s", 60.0, note=from_both),
    ]


def write_long(path: Path, turns: int) -> None:
    """Write the story several times over, in commits as the recorder makes them."""
    with SessionWriter(path) as writer:
        for turn in range(turns):
            for k, m in enumerate(Story(begins=turn * END).build()):
                count = m.sequence + turn * 100_000
                writer.add(Message(m.source, m.data, m.log_time, count))
                if k % COMMIT == 0:
                    writer.commit()
        writer.commit()


def _timed(act: Callable[[], T]) -> tuple[float, T]:
    began = time.monotonic()
    value = act()
    return time.monotonic() - began, value


def _processor(act: Callable[[], object]) -> float:
    began = time.process_time()
    act()
    return time.process_time() - began


def _peak_of_reading(path: Path) -> int:
    """Most memory that a process of its own takes to read a recording [B]."""
    done = subprocess.run(
        [sys.executable, "-c", READ, str(path)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        check=True,
        text=True,
    )
    return int(done.stdout) * 1024
