# SPDX-License-Identifier: BSD-3-Clause
"""The recorder node beside `rosbag record`: CPU, memory and loss on the same traffic in one run."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from subprocess import DEVNULL
from typing import Any

import rosgraph

from bench.recording import traffic as sessions_traffic
from session_log.cli import CONFIG
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
from support.figures import ROOT, Figure
from typed_config import load_yaml

SECONDS = 24.0  # [s] of traffic
SETTLE = 5.0  # [s] of it before CPU and memory are measured
ROSBAG = ("/usr/lib/rosbag/record", "/opt/ros/noetic/lib/rosbag/record")
RECORDER = ROOT / "catkin_ws" / "src" / "session_log" / "scripts" / "recorder"


@dataclass(frozen=True)
class Usage:
    """What a process has used so far."""

    time: float  # [s] of CPU
    memory: int  # [B] resident


@dataclass(frozen=True)
class Ros:
    """A roscore of our own."""

    environment: dict[str, str]
    master: Any  # rosgraph.Master

    def start(
        self, command: list[str], stdout: int = DEVNULL, stdin: int = DEVNULL
    ) -> subprocess.Popen[bytes]:
        """Start a program that knows this roscore."""
        pipes = {"stdout": stdout, "stdin": stdin, "stderr": DEVNULL}
        return subprocess.Popen(command, env=self.environment, cwd=ROOT, **pipes)

    def start_recorder(self, folder: Path) -> subprocess.Popen[bytes]:
        """Start the recorder node; its session is the folder itself."""
        settings = dict(load_yaml(CONFIG.with_name("recorder.yaml")))
        self.master.setParam("/recorder", {**settings, "folder": str(folder), "name": "."})
        return self.start([sys.executable, str(RECORDER)])


@contextmanager
def roscore(folder: Path) -> Iterator[Ros]:
    """Run a roscore on a free port of the loopback."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environment = {
        **os.environ,
        "ROS_IP": "127.0.0.1",
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_LOG_DIR": str(folder / "ros"),
    }
    master = rosgraph.Master("/bench", master_uri=environment["ROS_MASTER_URI"])
    ros = Ros(environment, master)
    core = ros.start(["roscore", "-p", str(port)])
    try:
        while not master.is_online():
            time.sleep(0.1)
        yield ros
    finally:
        end(core)


def end(process: subprocess.Popen[bytes] | None) -> None:
    """Ask a process to end, and wait for it."""
    if process is None or process.poll() is not None:
        return
    process.send_signal(signal.SIGINT)
    try:
        process.wait(20.0)
    except subprocess.TimeoutExpired:  # what a background shell starts does not heed SIGINT
        process.terminate()
        process.wait(20.0)


def node() -> list[Figure]:
    """Measure the recorder node, and rosbag where it is installed."""
    with tempfile.TemporaryDirectory() as name, roscore(Path(name)) as ros:
        folder = Path(name)
        recorder = ros.start_recorder(folder / "node")
        program = next((p for p in ROSBAG if Path(p).exists()), None)
        bag = str(folder / "r.bag")
        rosbag = ros.start([program, "-a", "-O", bag]) if program else None
        time.sleep(3.0)
        command = [sys.executable, sessions_traffic.__file__, "talk", str(SECONDS)]
        talker = ros.start(command, subprocess.PIPE)
        used = _measure(recorder, rosbag)
        end(rosbag)  # the bursts are for the recorder alone
        said = [json.loads(line) for line in talker.communicate()[0].splitlines()]
        end(recorder)
        found = {
            t: c.messages for t, c in read_summary(SessionReader(folder / "node")).topics.items()
        }
    published = said[0]["published"]
    lost = sum(published - found.get(t, 0) for t in sessions_traffic.TOPICS)
    traffic = "3 topics at 500 Hz, and sound"
    return [
        *used,
        Figure("lost by the node", lost, f"of {3 * published}", 0.0, note=traffic),
        *_bursts(said[1]["bursts"], found),
    ]


def _measure(
    recorder: subprocess.Popen[bytes], rosbag: subprocess.Popen[bytes] | None
) -> list[Figure]:
    time.sleep(SETTLE)
    before = [_usage(p) for p in (recorder, rosbag)]
    time.sleep(SECONDS - SETTLE - 2.0)
    after = [_usage(p) for p in (recorder, rosbag)]
    span = SECONDS - SETTLE - 2.0
    figures = []
    for name, target, a, b in zip(
        ("recorder", "rosbag record"), (30.0, None), before, after, strict=True
    ):
        if a is None or b is None:
            continue
        figures += [
            Figure(f"{name}: CPU", 100 * (b.time - a.time) / span, "% of a core", target),
            Figure(f"{name}: memory", b.memory / 1e6, "MB"),
            Figure(
                f"{name}: memory grown", (b.memory - a.memory) / 1e6, "MB", note=f"in {span:g} s"
            ),
        ]
    return figures


def _bursts(bursts: list[dict[str, float]], found: dict[str, int]) -> list[Figure]:
    """The highest rate that was published and recorded whole, and what became of each."""
    kept, notes = 0.0, []
    for burst in bursts:
        lost = burst["count"] - found.get(f"/burst_{burst['asked']:g}", 0)
        notes.append(f"{burst['rate']:.0f}/s: {lost:g} lost")
        if lost <= 0:
            kept = max(kept, burst["rate"])
    return [
        Figure("through ROS without loss", kept, "messages/s", note="(" + ", ".join(notes) + ")")
    ]


def _usage(process: subprocess.Popen[bytes] | None) -> Usage | None:
    if process is None:
        return None
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    pages = int(Path(f"/proc/{process.pid}/statm").read_text().split()[1])
    ticks = int(fields[11]) + int(fields[12])
    return Usage(ticks / os.sysconf("SC_CLK_TCK"), pages * os.sysconf("SC_PAGE_SIZE"))
