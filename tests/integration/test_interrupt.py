# SPDX-License-Identifier: BSD-3-Clause
"""What asks the demo to end must not leave a robot running behind it."""

import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader

from support.waiting import PATIENCE, wait_until
from tests.integration.heeding import heed

ROOT = Path(__file__).resolve().parents[2]
DEMO = [sys.executable, "-m", "demo", "--wav"]
SHORT = ROOT / "tests" / "data" / "short_session.yaml"
PROGRAM = """
import sys, time
from pathlib import Path
from support.interrupt import end_as_by_ctrl_c
from support.launched_system import System

end_as_by_ctrl_c()
with System(Path(sys.argv[1]), {}) as system:
    print(*(process.pid for process in system._launches), flush=True)
    time.sleep(600)
"""


@pytest.mark.parametrize("request_to_end", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_the_system_ends_with_who_started_it(tmp_path, request_to_end):
    command = [sys.executable, "-c", PROGRAM, str(tmp_path / "launch.log")]
    with subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, text=True, preexec_fn=heed
    ) as program:
        groups = [int(word) for word in program.stdout.readline().split()]
        assert groups
        assert all(members(group) for group in groups)
        for wait in (0.5, PATIENCE):  # who asks again while it is ending does not get less
            program.send_signal(request_to_end)
            with contextlib.suppress(subprocess.TimeoutExpired):
                program.wait(wait)
        is_over = program.poll() is not None
        if not is_over:  # or this waits for it, and what it started stays
            program.send_signal(signal.SIGTERM)
    assert is_over
    assert [member for group in groups for member in members(group)] == []


def members(group):
    """Processes of a group."""
    listing = subprocess.run(["ps", "-e", "-o", "pgid=,pid="], capture_output=True, text=True)
    rows = [tuple(map(int, line.split())) for line in listing.stdout.splitlines()]
    return [pid for pgid, pid in rows if pgid == group and pid != os.getpid()]


def test_ctrl_c_ends_everything_and_leaves_a_readable_recording(tmp_path):
    demo = subprocess.Popen(
        [*DEMO, "--script", str(SHORT), "--out", str(tmp_path)],
        cwd=ROOT,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=heed,
    )
    shown = ""
    while not all(f"{part} ready" in shown for part in ("recorder", "robot", "voice")):
        line = demo.stdout.readline()
        assert line, f"ended before the system was up: {shown}"
        shown += line
    demo.send_signal(signal.SIGINT)
    shown += demo.communicate(timeout=PATIENCE)[0]
    assert demo.returncode == 130, shown
    with (tmp_path / "session.mcap").open("rb") as stream:
        assert any(True for _ in make_reader(stream).iter_messages(topics=["/joint_states"]))
    with contextlib.suppress(RuntimeError):  # what was killed needs a moment
        wait_until(lambda: not started_by(tmp_path))
    assert started_by(tmp_path) == []


def started_by(folder):
    """Commands of the processes whose logs are in a folder."""
    commands = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            environment = (process / "environ").read_bytes()
            if int(process.name) != os.getpid() and f"{folder}/ros_logs".encode() in environment:
                commands.append((process / "cmdline").read_bytes().decode())
    return commands
