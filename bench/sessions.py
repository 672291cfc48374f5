# SPDX-License-Identifier: BSD-3-Clause
"""Recording: loss under SIGKILL, messages per second, CPU and memory, reading, reporting."""

from __future__ import annotations

import json
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import rosgraph

from bench.figures import ROOT, Figure
from session_log.cli import CONFIG
from session_log.config import RecorderConfig, ReportConfig
from session_log.reader import SessionReader
from session_log.recorder import Recorder
from session_log.report import write_report
from session_log.survey import survey
from session_log.types import Message, Source
from session_log.writer import SessionWriter
from typed_config import load_config, load_yaml

KILLS = 200
AT_ONCE = 4  # processes under traffic at the same time
NODE_SECONDS = 20.0  # [s] of traffic for CPU and memory
RATE = 500  # [Hz] of each of the three fast topics
SIZE = 320  # [B] of a JointState with ten joints
FLOOD = 300_000  # messages offered as fast as they come
ROSBAG = ("/usr/lib/rosbag/record", "/opt/ros/noetic/lib/rosbag/record")
RECORDER = ROOT / "catkin_ws" / "src" / "session_log" / "scripts" / "recorder"


def measure() -> list[Figure]:
    """Measure everything; about three minutes."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        return [*_kills(folder), *_flood(folder), *_node(folder), *_reading(folder)]


def _settings() -> dict[str, object]:
    return dict(load_yaml(CONFIG.with_name("recorder.yaml")))


def _kills(folder: Path) -> list[Figure]:
    with ThreadPoolExecutor(AT_ONCE) as pool:
        results = list(pool.map(lambda k: _kill(folder / f"kill{k}.mcap", k), range(KILLS)))
    lost = sum(max(acknowledged - found, 0) for acknowledged, found, _ in results)
    total = sum(acknowledged for acknowledged, *_ in results)
    late = [behind * 1e3 for *_, behind in results if behind is not None]
    return [
        Figure("processes killed", KILLS, "", KILLS, at_most=False, note="500 Hz x 3 and sound"),
        Figure("messages acknowledged before the kills", total, ""),
        Figure("acknowledged messages lost", lost, "", 0.0),
        Figure("received last before the kill, not in the file", max(late, default=0.0), "ms"),
    ]


def _kill(path: Path, seed: int) -> tuple[int, int, float | None]:
    """Kill one recorder under traffic; returns acknowledged, found, and the age of the last [s]."""
    process = subprocess.Popen(
        [sys.executable, __file__, "traffic", str(path)],
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
    found, last = 0, None
    for message in SessionReader(path).messages():
        found, last = found + 1, message.log_time
    path.unlink()
    return acknowledged, found, None if last is None else max(killed - last, 0) * 1e-9


def _traffic(path: Path) -> None:
    """Record three topics of 500 Hz and sound from threads, as rospy would deliver them."""
    config = load_config(RecorderConfig, _settings())
    recorder = Recorder(lambda: SessionWriter(path), config, time.time_ns)
    sources = [Source(f"/t{i}", "std_msgs/String", "992c", "string data", "/p") for i in range(4)]
    sizes, rates = [SIZE, SIZE, 80, 1024], [RATE, RATE, RATE, 31]
    recorder.start()
    for source, size, rate in zip(sources, sizes, rates, strict=True):
        arguments = (recorder, recorder.register(source), bytes(size), 1.0 / rate)
        threading.Thread(target=_publish, args=arguments, daemon=True).start()
    while True:
        time.sleep(0.01)
        sys.stdout.write(f"{recorder.status().written}\n")
        sys.stdout.flush()


def _publish(recorder: Recorder, tally: object, data: bytes, period: float) -> None:
    due = time.monotonic()
    while True:
        recorder.offer(tally, data)  # type: ignore[arg-type]
        due += period
        time.sleep(max(due - time.monotonic(), 0.0))


def _flood(folder: Path) -> list[Figure]:
    config = load_config(RecorderConfig, _settings())
    path = folder / "flood.mcap"
    recorder = Recorder(lambda: SessionWriter(path), config, time.time_ns)
    tally = recorder.register(Source("/t", "std_msgs/String", "992c", "string data", "/p"))
    recorder.start()
    began, data = time.monotonic(), bytes(SIZE)
    for _ in range(FLOOD):
        recorder.offer(tally, data)
    problem = recorder.close()
    took = time.monotonic() - began
    found = survey(SessionReader(path))
    path.unlink()
    return [
        Figure("recorded without loss", FLOOD / took, "messages/s", note=f"{SIZE} B, {problem}"),
        Figure("lost of the flood", FLOOD - found.messages, ""),
    ]


@contextmanager
def _roscore(folder: Path):  # noqa: ANN202 - a context of the environment
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environment = {
        **os.environ,
        "ROS_IP": "127.0.0.1",
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_LOG_DIR": str(folder / "ros"),
        "PYTHONPATH": os.pathsep.join(sys.path),
    }
    core = _start(["roscore", "-p", str(port)], environment)
    try:
        master = rosgraph.Master("/bench", master_uri=environment["ROS_MASTER_URI"])
        while not master.is_online():
            time.sleep(0.1)
        yield environment, master
    finally:
        _end(core)


def _node(folder: Path) -> list[Figure]:
    """CPU and memory of the recorder node, beside rosbag where it is installed, in one run."""
    with _roscore(folder) as (environment, master):
        master.setParam("/recorder", {**_settings(), "folder": str(folder), "name": "node"})
        node = _start([sys.executable, str(RECORDER)], environment)
        bag = folder / "r.bag"
        program = next((p for p in ROSBAG if Path(p).exists()), None)
        rosbag = _start([program, "-a", "-O", str(bag)], environment) if program else None
        time.sleep(3.0)
        talker = _start([sys.executable, __file__, "talk"], environment, subprocess.PIPE)
        time.sleep(4.0)
        before = [_ticks(p) for p in (node, rosbag)]
        time.sleep(NODE_SECONDS - 6.0)
        after = [_ticks(p) for p in (node, rosbag)]
        memory = _memory(node)
        published = json.loads(talker.communicate()[0])["published"]
        _end(node)
        if rosbag:
            _end(rosbag)
    found = survey(SessionReader(folder / "node")).topics
    hertz = os.sysconf("SC_CLK_TCK") * (NODE_SECONDS - 6.0)
    lost = 3 * published - sum(found[t].messages for t in ("/joint_states", "/servo", "/tension"))
    figures = [
        Figure("recorder's CPU", 100 * (after[0] - before[0]) / hertz, "% of a core", 30.0),
        Figure("recorder's memory", memory / 1e6, "MB"),
        Figure("messages of the node's run lost", lost, f"of {3 * published}", 0.0),
    ]
    if rosbag:
        cpu = 100 * (after[1] - before[1]) / hertz
        figures.append(Figure("rosbag record's CPU, same run", cpu, "% of a core"))
    return figures


def _talk() -> None:
    """Publish 500 Hz on three topics until the time is over."""
    import rospy
    from geometry_msgs.msg import WrenchStamped
    from sensor_msgs.msg import JointState

    rospy.init_node("talker")
    kinds = {"/joint_states": JointState, "/servo": JointState, "/tension": WrenchStamped}
    out = {t: rospy.Publisher(t, kind, queue_size=2000) for t, kind in kinds.items()}
    joints = JointState(name=[f"joint_{i}" for i in range(10)], position=[0.0] * 10)
    joints.velocity = joints.effort = [0.0] * 10
    messages = {JointState: joints, WrenchStamped: WrenchStamped()}
    while not all(p.get_num_connections() for p in out.values()):
        rospy.sleep(0.05)
    rospy.sleep(0.5)
    count, rate, end = 0, rospy.Rate(RATE), time.monotonic() + NODE_SECONDS
    while time.monotonic() < end:
        for topic, publisher in out.items():
            publisher.publish(messages[kinds[topic]])
        count += 1
        rate.sleep()
    rospy.sleep(1.0)
    print(json.dumps({"published": count}), flush=True)


def _reading(folder: Path) -> list[Figure]:
    path = folder / "long.mcap"
    _write_long(path, 300)
    began = time.monotonic()
    found = survey(SessionReader(path))
    read = time.monotonic() - began
    config = load_config(ReportConfig, load_yaml(CONFIG), CONFIG.name)
    began = time.monotonic()
    write_report(SessionReader(path), folder / "report", config)
    report = time.monotonic() - began
    hours = found.duration / 3600
    return [
        Figure("read", found.messages / read, "messages/s"),
        Figure("read", path.stat().st_size / read / 1e6, "MB/s"),
        Figure("report of a session of five minutes", report, "s"),
        Figure("report per hour of session", report / hours, "s", note="extrapolated"),
    ]


def _write_long(path: Path, seconds: int) -> None:
    from tests.unit.session_log.synthetic_session import END, Story

    story = list(Story().build())
    with SessionWriter(path) as writer:
        for turn in range(round(seconds / END)):
            shift = int(turn * END * 1e9)
            for m in story:
                count = m.sequence + turn * 100_000
                writer.add(Message(m.source, m.data, m.log_time + shift, count))
            writer.commit()


def _start(
    command: list[str], environment: dict[str, str], stdout: int = subprocess.DEVNULL
) -> subprocess.Popen[bytes]:
    return subprocess.Popen(command, env=environment, cwd=ROOT, stdout=stdout)


def _end(process: subprocess.Popen[bytes]) -> None:
    process.send_signal(signal.SIGINT)
    process.wait(30.0)


def _ticks(process: subprocess.Popen[bytes] | None) -> int:
    """CPU time of a process [clock ticks]."""
    if process is None:
        return 0
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return int(fields[11]) + int(fields[12])


def _memory(process: subprocess.Popen[bytes]) -> int:
    """Resident memory of a process [B]."""
    pages = int(Path(f"/proc/{process.pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


PARTS: dict[str, Callable[..., None]] = {"traffic": _traffic, "talk": _talk}

if __name__ == "__main__":
    PARTS[sys.argv[1]](*map(Path, sys.argv[2:]))
