# SPDX-License-Identifier: BSD-3-Clause
"""What asks the demo to end must not leave a robot running behind it."""

import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from support.waiting import PATIENCE
from tests.integration.heeding import heed

ROOT = Path(__file__).resolve().parents[2]
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
