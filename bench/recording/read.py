# SPDX-License-Identifier: BSD-3-Clause
"""How fast recordings are read and reported, one and many."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from session_log.cli import CONFIG
from session_log.config import ReportConfig
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
from session_log.mcap_file.writer import SessionWriter
from session_log.report.many_sessions import folder
from session_log.report.one_session import write_report
from session_log.types import Message
from support.figures import Figure
from support.story import Story
from support.story_script import END
from typed_config import load_config, load_yaml

TURNS = 6  # of the story in one recording
COMMIT = 10  # messages in one, as the recorder's at 500 Hz
SESSIONS = 12  # in the folder
JOBS = 2
READ = """
import resource, sys
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
read_summary(SessionReader(sys.argv[1]))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""

T = TypeVar("T")


def reading() -> list[Figure]:
    """Read and report one recording of a few minutes."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "long.mcap"
        write_long(path, TURNS)
        size = path.stat().st_size
        short = Path(name) / "short.mcap"
        write_long(short, 1)
        grown = (_peak_of_reading(path) - _peak_of_reading(short)) / 1e6
        read, found = _timed(lambda: read_summary(SessionReader(path)))
        report, _ = _timed(lambda: write_report(SessionReader(path), Path(name) / "out", _config()))
    if found.condition.damage or found.condition.checksum != "good":
        raise RuntimeError(f"a recording of our own is read as damaged: {found.condition.damage}")
    hours = found.duration / 3600.0
    note = f"(from {found.duration:.0f} s)"
    return [
        Figure("read", found.messages / read, "messages/s"),
        Figure("read", size / read / 1e6, "MB/s", note=f"({size / 1e6:.0f} MB)"),
        Figure(f"memory: {TURNS} times as long a file takes", grown, "MB more", 5.0),
        Figure("size of an hour of session", size / hours / 1e9, "GB", note=note),
        Figure("report of an hour of session", report / hours, "s", note=note),
    ]


def many() -> list[Figure]:
    """Report a folder of recordings in one process and on two cores."""
    with tempfile.TemporaryDirectory() as name:
        sessions = Path(name) / "sessions"
        first = sessions / "0" / "session.mcap"
        first.parent.mkdir(parents=True)
        write_long(first, 1)
        for k in range(1, SESSIONS):
            (sessions / str(k)).mkdir()
            shutil.copy(first, sessions / str(k) / "session.mcap")
        hours = SESSIONS * read_summary(SessionReader(first)).duration / 3600.0
        took = {
            jobs: _timed(
                lambda jobs=jobs: folder(
                    [sessions], Path(name) / f"out{jobs}", _config(), jobs=jobs
                )
            )[0]
            for jobs in (1, JOBS)
        }
    note = f"({SESSIONS} sessions)"
    return [
        Figure("folder: time per hour of session, one process", took[1] / hours, "s", note=note),
        Figure("folder: time per hour of session, two cores", took[JOBS] / hours, "s", note=note),
        Figure("folder: core-seconds per hour of session", JOBS * took[JOBS] / hours, "s"),
        Figure("folder: two cores faster by", took[1] / took[JOBS], "times"),
    ]


def write_long(path: Path, turns: int) -> None:
    """Write the story several times over, in commits as the recorder makes them."""
    story = list(Story().build())
    with SessionWriter(path) as writer:
        for turn in range(turns):
            shift = int(turn * END * 1e9)
            for k, m in enumerate(story):
                count = m.sequence + turn * 100_000
                writer.add(Message(m.source, m.data, m.log_time + shift, count))
                if k % COMMIT == 0:
                    writer.commit()
        writer.commit()


def _config() -> ReportConfig:
    return load_config(ReportConfig, load_yaml(CONFIG), CONFIG.name)


def _timed(act: Callable[[], T]) -> tuple[float, T]:
    began = time.monotonic()
    value = act()
    return time.monotonic() - began, value


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
