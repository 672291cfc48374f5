# SPDX-License-Identifier: BSD-3-Clause
"""What the kernel says of a process."""

import os
import signal
import socket
import subprocess
import sys
import time

import pytest

from rst_control.processes import ENDED, STOPPED, Process, process_of

SERVER = """
import socket, sys
server = socket.create_server(("127.0.0.1", 0))
print(server.getsockname()[1], flush=True)
sys.stdin.read()
"""
LIMIT = 20.0  # [s] for the kernel to carry out a signal


@pytest.fixture
def server():
    """A process that listens, and its port."""
    command = (sys.executable, "-c", SERVER)
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        yield process, int(process.stdout.readline())
        process.kill()


def becomes(process, words):
    end = time.monotonic() + LIMIT
    while process.state() != words:
        assert time.monotonic() < end, process.state()


def test_one_that_runs_is_well_whether_it_works_or_waits(server):
    waiting = process_of(server[0].pid, server[1])
    with socket.create_server(("127.0.0.1", 0)) as own:
        working = process_of(os.getpid(), own.getsockname()[1])
    for _ in range(100):
        assert waiting.state() == working.state() == ""


def test_one_that_is_stopped_is_told_and_well_again_when_it_goes_on(server):
    process = process_of(server[0].pid, server[1])
    server[0].send_signal(signal.SIGSTOP)
    becomes(process, STOPPED)
    server[0].send_signal(signal.SIGCONT)
    becomes(process, "")


def test_one_that_was_killed_has_ended_before_and_after_its_parent_looks(server):
    process = process_of(server[0].pid, server[1])
    server[0].kill()
    becomes(process, ENDED)
    server[0].wait()
    assert process.state() == ENDED


def test_another_with_the_same_number_is_not_taken_for_it():
    own = process_of_self()
    assert Process(own.pid, own.started + "0").state() == ENDED


def process_of_self():
    with socket.create_server(("127.0.0.1", 0)) as own:
        return process_of(os.getpid(), own.getsockname()[1])


def test_who_does_not_listen_there_is_not_believed(server):
    assert process_of(os.getpid(), server[1]) is None
    assert process_of(server[0].pid, 1) is None
    assert process_of(2**22 + 1, server[1]) is None


def test_a_name_with_spaces_and_brackets_hides_nothing(tmp_path):
    folder = tmp_path / "7" / "task" / "7"
    folder.mkdir(parents=True)
    tail = " ".join(["1"] * 18)
    (folder / "stat").write_text(f"7 (a) S (b) T {tail} 42 0 0\n")
    assert Process(7, "42").state(tmp_path) == STOPPED
    (folder / "stat").write_text(f"7 (a) T (b) S {tail} 42 0 0\n")
    assert Process(7, "42").state(tmp_path) == ""
