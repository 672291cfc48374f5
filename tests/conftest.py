# SPDX-License-Identifier: BSD-3-Clause
"""Runs each tests/rostest/*.test as one pytest item, on a master of its own on loopback."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import time
from pathlib import Path

import hypothesis
import pytest

from support.launched_system import free_port

ROOT = Path(__file__).resolve().parent.parent
# scripts that tests start import `support` and `tests` as well
os.environ["PYTHONPATH"] = os.pathsep.join((str(ROOT), os.environ.get("PYTHONPATH", "")))
START_TIME = 30.0  # [s] allowed for roscore to answer
TOLD = 8000  # characters of a failed rostest's output
TIME_LIMIT = 240.0  # [s] for one .test file, start and end of its nodes included

# The same examples each time, so that a failure says something of the change at hand; EXPLORE=1
# looks at others, and many more of them.
hypothesis.settings.register_profile("fixed", derandomize=True, deadline=None)
hypothesis.settings.register_profile("explore", max_examples=2000, deadline=None)
hypothesis.settings.load_profile("explore" if os.environ.get("EXPLORE") else "fixed")


def pytest_collect_file(file_path, parent):
    if file_path.suffix == ".test" and file_path.parent.name == "rostest":
        return RosTestFile.from_parent(parent, path=file_path)
    return None


class RosTestFile(pytest.File):
    def collect(self):
        yield RosTest.from_parent(self, name=self.path.stem)


class RosTest(pytest.Item):
    def runtest(self):
        port = free_port()
        environment = {
            **os.environ,
            "ROS_IP": "127.0.0.1",
            "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
            "ROS_HOME": str(ROOT / ".cache" / "ros"),
        }
        command = ["rostest", "--text", "--reuse-master", f"--pkgdir={ROOT}", "--package=tests"]
        master = subprocess.Popen(
            ["roscore", "-p", str(port)],
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            wait_for_master(port)
            self._run([*command, str(self.path)], environment)
        finally:
            master.send_signal(signal.SIGINT)
            master.wait(15.0)

    def _run(self, command, environment):
        process = subprocess.Popen(
            command,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        try:
            output, _ = process.communicate(timeout=TIME_LIMIT)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise RosTestError(f"no end within {TIME_LIMIT:g} s") from None
        # rostest ends with 0 whatever its tests did: only its summary tells
        count = {key: int(n) for key, n in re.findall(r"(TESTS|ERRORS|FAILURES): (\d+)", output)}
        passed = count.get("TESTS", 0) > 0 and count["ERRORS"] == count["FAILURES"] == 0
        if process.returncode or not passed:
            raise RosTestError(worth_reading(output)[-TOLD:])

    def repr_failure(self, excinfo, style=None):
        if isinstance(excinfo.value, RosTestError):
            return f"{self.path.name}\n{excinfo.value}"
        return super().repr_failure(excinfo, style)

    def reportinfo(self):
        return self.path, 0, f"rostest {self.path.name}"


def worth_reading(output):
    """What a rostest printed until its tests were over, without roslaunch's list of parameters.

    The list fills pages, and so does what nodes say of being ended.
    """
    until = output.partition("[ROSTEST]tearDown")[0]
    return "".join(line for line in until.splitlines(keepends=True) if not line.startswith(" * /"))


def wait_for_master(port):
    deadline = time.monotonic() + START_TIME
    while time.monotonic() < deadline:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    raise RosTestError(f"roscore did not answer within {START_TIME:g} s")


def pytest_runtest_logreport(report):
    """Keep which tests failed, for who runs them again (tests/__main__.py)."""
    kept = os.environ.get("FAILED_TESTS")
    if kept and report.failed:
        with Path(kept).open("a", encoding="utf-8") as lines:
            lines.write(f"{report.nodeid}\n")


class RosTestError(Exception):
    """A rostest failed, ran nothing or did not end."""
