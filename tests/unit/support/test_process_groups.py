# SPDX-License-Identifier: BSD-3-Clause
"""What a program starts in a group of its own ends with it, in order, whatever ends the program."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from support.process_groups import end_group, start_group
from support.waiting import wait_until

# Notes its number, and that it was asked to end.
CHILD = """
import signal, sys, time, os, pathlib
def end(*_):
    pathlib.Path(sys.argv[1], "asked").touch()
    sys.exit(0)
signal.signal(signal.SIGINT, end)
pathlib.Path(sys.argv[1], "started").write_text(str(os.getpid()))
time.sleep(600)
"""
PARENT = """
import sys, threading
from support.process_groups import start_group
def start():
    start_group([sys.executable, "-c", sys.argv[1], sys.argv[2]])
if sys.argv[3] == "main":
    start()
else:
    thread = threading.Thread(target=start)
    thread.start()
    thread.join()
input()
"""


def started(folder):
    file = folder / "started"
    wait_until(lambda: file.exists() and file.read_text())
    return int(file.read_text())


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_what_was_started_is_asked_to_end_where_its_starter_is_killed(tmp_path, number):
    words = [sys.executable, "-c", PARENT, CHILD, str(tmp_path), "main"]
    parent = subprocess.Popen(words, stdin=subprocess.PIPE)
    child = started(tmp_path)
    parent.send_signal(number)
    parent.wait()
    wait_until((tmp_path / "asked").exists)
    wait_until(lambda: not is_there(child))


def test_the_end_of_a_thread_that_started_something_ends_nothing(tmp_path):
    words = [sys.executable, "-c", PARENT, CHILD, str(tmp_path), "thread"]
    with subprocess.Popen(words, stdin=subprocess.PIPE) as parent:
        child = started(tmp_path)
        time.sleep(0.2)  # its thread has ended
        assert is_there(child) and not (tmp_path / "asked").exists()
        os.kill(child, signal.SIGKILL)
        parent.kill()


def test_a_group_is_asked_to_end_and_then_made_to(tmp_path):
    process = start_group([sys.executable, "-c", CHILD, str(tmp_path)])
    started(tmp_path)
    end_group(process)
    assert process.returncode == 0 and (tmp_path / "asked").exists()
    deaf = start_group(["sh", "-c", "trap '' INT; echo; sleep 60"], stdout=subprocess.PIPE)
    deaf.stdout.readline()
    end_group(deaf, patience=0.1)
    assert deaf.returncode == -signal.SIGKILL


def test_who_runs_in_the_background_of_a_shell_ends_what_it_starts_at_once():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as that shell does
    try:
        process = start_group(["sleep", "60"])
        end_group(process)
    finally:
        signal.signal(signal.SIGINT, before)
    assert process.returncode == -signal.SIGINT


def is_there(pid):
    """A process of this number runs: one that ended and is not waited for does not."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] != "Z"
