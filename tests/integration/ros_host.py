# SPDX-License-Identifier: BSD-3-Clause
"""A master and launches beside it, as on a machine of its own; each can be killed alone."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

import rosgraph

from support.launched_system import end_group, free_port

ROOT = Path(__file__).resolve().parents[2]
ROSTEST = ROOT / "tests" / "rostest"
WAIT = 90.0  # [s] for anything to happen on a loaded machine
END = 20.0  # [s] for a process to end


class Host:
    """A master and launches, each in a process group of its own."""

    def __init__(self, folder, monkeypatch):
        self.port = free_port()
        monkeypatch.setenv("ROS_IP", "127.0.0.1")
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{self.port}")
        monkeypatch.setenv("ROS_LOG_DIR", str(folder / "logs"))
        self._log = (folder / "said.txt").open("ab")
        self._running = []
        self.master = rosgraph.Master("/test", f"http://127.0.0.1:{self.port}")

    def start(self, *words, beside=None):
        """Begin a process; `beside` holds variables for its environment alone."""
        process = subprocess.Popen(
            words,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env={**os.environ, **(beside or {})},
        )
        self._running.append(process)
        return process

    def start_master(self):
        process = self.start("roscore", "-p", str(self.port))
        until(self.is_there, "a master")
        return process

    def launch(self, name, beside=None, **arguments):
        words = [f"{key}:={value}" for key, value in arguments.items()]
        file = str(ROOT / "launch" / f"{name}.launch")
        return self.start("roslaunch", "--wait", file, *words, beside=beside)

    def is_there(self):
        try:
            return bool(self.master.getPid())
        except (OSError, rosgraph.MasterException):
            return False

    def is_found(self, service):
        try:
            return bool(self.master.lookupService(service))
        except (OSError, rosgraph.MasterException):
            return False

    def end(self):
        for process in reversed(self._running):
            end_group(process, END)
        self._log.close()


def until(is_done, what):
    end = time.monotonic() + WAIT
    while not is_done():
        assert time.monotonic() < end, f"never: {what}"
        time.sleep(0.05)
