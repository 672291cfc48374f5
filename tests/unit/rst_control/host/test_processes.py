# SPDX-License-Identifier: BSD-3-Clause
"""What the kernel says of a process."""

import os
import signal
import socket
import subprocess
import sys

import pytest

from rst_control.host.processes import ENDED, STOPPED, Process, process_of
from support.waiting import wait_until

SERVER = """
import socket, sys
server = socket.create_server(("127.0.0.1", 0))
print(server.getsockname()[1], flush=True)
sys.stdin.read()
"""


@pytest.fixture
def server():
    """A process that listens, and its port."""
    command = (sys.executable, "-c", SERVER)
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        yield process, int(process.stdout.readline())
        process.kill()


def process_of_self():
    with socket.create_server(("127.0.0.1", 0)) as own:
        return process_of(os.getpid(), own.getsockname()[1])


def becomes(process, words):
    wait_until(lambda: process.state() == words, words or "running")


def test_one_that_runs_is_well_whether_it_works_or_waits(server):
    waiting, working = process_of(server[0].pid, server[1]), process_of_self()
    for _ in range(100):
        assert waiting.state() == working.state() == ""


def test_one_that_is_stopped_is_reported_and_well_again_when_it_goes_on(server):
    process = process_of(server[0].pid, server[1])
    server[0].send_signal(signal.SIGSTOP)
    becomes(process, STOPPED)
    server[0].send_signal(signal.SIGCONT)
    becomes(process, "")


def test_one_that_was_killed_has_ended_before_and_after_its_parent_waits_for_it(server):
    process = process_of(server[0].pid, server[1])
    server[0].kill()
    becomes(process, ENDED)
    server[0].wait()
    assert process.state() == ENDED


def test_another_with_the_same_number_is_not_taken_for_it():
    own = process_of_self()
    assert Process(own.pid, own.started + "0").state() == ENDED


def test_who_does_not_listen_there_is_not_believed(server):
    assert process_of(os.getpid(), server[1]) is None
    assert process_of(server[0].pid, 1) is None
    assert process_of(2**22 + 1, server[1]) is None


def state_of(tmp_path, name, state, flags=0x400000, pending=0):
    """What is made of a stat file with these fields, of a process started at tick 42."""
    folder = tmp_path / "7" / "task" / "7"
    folder.mkdir(parents=True, exist_ok=True)
    before, between = " ".join(["1"] * 5), " ".join(["1"] * 12)  # parent and on; faults and on
    after = " ".join(["1"] * 8)  # size and on
    line = f"7 ({name}) {state} {before} {flags} {between} 42 {after} {pending} 0 0 0\n"
    (folder / "stat").write_text(line)
    return Process(7, "42").state(tmp_path)


def test_a_name_with_spaces_and_brackets_hides_nothing(tmp_path):
    assert state_of(tmp_path, "a) S (b", "T") == STOPPED
    assert state_of(tmp_path, "a) T (b", "S") == ""


def test_one_that_is_being_taken_down_has_ended_though_it_still_holds_its_memory(tmp_path):
    assert state_of(tmp_path, "a", "R", flags=0x400004) == ENDED


def test_one_that_was_killed_has_ended_before_it_gets_a_processor_to_die_on(tmp_path):
    assert state_of(tmp_path, "a", "R", pending=1 << (signal.SIGKILL - 1)) == ENDED
    assert state_of(tmp_path, "a", "R", pending=1 << (signal.SIGUSR1 - 1)) == ""
    assert state_of(tmp_path, "a", "S") == ""
