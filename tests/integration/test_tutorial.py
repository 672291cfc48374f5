# SPDX-License-Identifier: BSD-3-Clause
"""docs/tutorial.md in its order, in terminals that use only what the page says.

Only settings are added, for a machine that may pause and for motions that take less time. Those
through the trocar take as long as a user's: the page stops one on its way.
"""

import fcntl
import os
import pty
import re
import shutil
import subprocess
import sys
import termios
import threading
import time
from collections import defaultdict
from contextlib import suppress
from pathlib import Path

import pytest

from support.launched_system import free_port
from support.process_groups import end_group
from support.waiting import PATIENCE, wait_until
from tests.support.ros_host import ROSTEST, patient_controller

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"<!-- terminal: (\w+)(, refused)? -->\n```\n(.*?)```", re.DOTALL)
ENDED = "ended with"
STARTING = ("not_connected", "not_recorded")
AT_REST = ("standby", "active", "halted")
PRINTER = Path(__file__).parent / "programs" / "state_printer.py"
START = 4 * PATIENCE  # [s] where the kinematics have to be compiled on a loaded machine
pytestmark = pytest.mark.timeout(600)


def steps():
    """Terminal, line and whether it is refused, as they stand on the page."""
    return [
        (block[1], line, bool(block[2]))
        for block in BLOCK.finditer(PAGE)
        for line in block[3].splitlines()
    ]


class Terminal:
    """A shell with the environment of a login and a port for the master; nothing else is set."""

    def __init__(self, home, master, log):
        environment = {
            "HOME": str(home),
            "XDG_CACHE_HOME": str(Path.home() / ".cache"),  # compiled kinematics, 20 s of work
            "PATH": "/usr/local/bin:/usr/bin:/bin",
            "ROS_MASTER_URI": master,
            "ROS_LOG_DIR": str(log),
        }
        self.printed = ""
        self.keys, terminal = pty.openpty()
        self.shell = subprocess.Popen(
            ["/bin/bash", "--noprofile", "--norc", "--noediting", "-i"],
            cwd=ROOT,
            env=environment,
            stdin=terminal,
            stdout=terminal,
            stderr=terminal,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(terminal, termios.TIOCSCTTY, 0),
        )
        os.close(terminal)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        with suppress(OSError):  # the shell has ended
            while printed := os.read(self.keys, 65536):
                self.printed += printed.decode(errors="replace")

    def type(self, line):
        """Type a line; gives where its output begins."""
        begin = len(self.printed)
        os.write(self.keys, f"{line}\n".encode())
        return begin

    def do(self, line):
        """Type a line and wait for its end; gives its exit code and what it printed."""
        begin = self.type(f"{line}; echo {ENDED} $?")
        found = wait_until(lambda: re.search(rf"{ENDED} (\d+)\r?\n", self.printed[begin:]), line)
        return int(found[1]), self.printed[begin : begin + found.start()]

    def wait_for(self, words):
        wait_until(lambda: words in self.printed or self.shell.poll() is not None, words, START)
        assert words in self.printed, self.printed[-3000:]

    def close(self):
        """Press Ctrl-C, then leave the shell; what runs is given time to end."""
        os.write(self.keys, b"\x03")
        wait_until(self._has_left, "the terminal is left", every=0.5)
        os.close(self.keys)

    def _has_left(self):
        with suppress(OSError):
            self.type("exit")
        return self.shell.poll() is not None


@pytest.fixture
def session():
    """The name of a session that no user has, in the place of the page's."""
    name = f"tutorial_{os.getpid()}"
    yield name
    shutil.rmtree(ROOT / "sessions" / name, ignore_errors=True)


class States:
    """What the controller says; a look by the page's `rostopic echo` would be a second of work."""

    def __init__(self, master, log):
        environment = {**os.environ, "ROS_MASTER_URI": master, "ROS_LOG_DIR": str(log)}
        words = (sys.executable, str(PRINTER))
        self._newest = "0 none"
        self._printer = subprocess.Popen(
            words, env=environment, stdout=subprocess.PIPE, text=True, start_new_session=True
        )
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self._printer.stdout:
            self._newest = line

    def wait_for_rest(self):
        """Wait for a state of after this call in which nothing moves."""
        begin = time.time()

        def rests():
            stamp, state = self._newest.split()
            return float(stamp) > begin and state in AT_REST

        wait_until(rests, "the motion ends")

    def close(self):
        end_group(self._printer)


def give(hand, states, line):
    """Give a command once the motion before it has ended; again while the robot is starting."""
    states.wait_for_rest()
    code, printed = hand.do(line)
    end = time.monotonic() + PATIENCE
    while "'hey robot'" in line and any(w in printed for w in STARTING) and time.monotonic() < end:
        code, printed = hand.do(line)
    return code, printed


def settings(folder):
    """Arguments of a launch."""
    slow = patient_controller(folder, ("insertion",), recording={"heartbeat_age": 10.0})
    return f"controller_overrides:={slow} robot_overrides:={ROSTEST}/patient_robot.yaml"


def test_the_page_can_be_followed(tmp_path, session):
    master = f"http://127.0.0.1:{free_port()}"
    terminals = defaultdict(lambda: Terminal(tmp_path, master, tmp_path / "ros"))
    states = None
    try:
        for name, typed, is_refused in steps():
            line = re.sub(r"\bfirst\b", session, typed)
            if line.startswith("roslaunch"):
                terminals[name].type(f"{line} {settings(tmp_path)}")
                terminals[name].wait_for("controller ready")
                states = States(master, tmp_path / "ros")
                continue
            if line.startswith("rosrun session_log") and "system" in terminals:
                terminals.pop("system").close()
            is_command = line.startswith("rosservice")
            hand = terminals[name]
            code, printed = give(hand, states, line) if is_command else hand.do(line)
            assert code == 0, (line, printed)
            assert not is_command or f"accepted: {not is_refused}" in printed, (line, printed)
        assert (ROOT / "sessions" / session / "report.html").is_file()
    finally:
        if states:
            states.close()
        for terminal in terminals.values():
            terminal.close()


def test_the_terminals_of_the_page_are_read_in_order():
    names = [name for name, *_ in steps()]
    lines = [line for _, line, _ in steps()]
    assert names[0] == "system" and names.count("system") == 2
    assert len(lines) > 14 and sum(refused for *_, refused in steps()) == 1
    assert lines[-1].startswith("rosrun session_log session_log report")
