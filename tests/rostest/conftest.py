# SPDX-License-Identifier: BSD-3-Clause
"""Runs each `<test>` of a `.test` file as one pytest item; all of a file share one launched system.

The system, on a master of its own, is started before the first of them and ends after the last.
"""

import os
import re
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from xml.etree import ElementTree

import pytest

from support.process_groups import start_group
from support.waiting import PATIENCE
from tests.support.ros_host import Host

HERE = Path(__file__).parent
SHOWN = 8000  # characters of what a failed rostest, or the system, said
# said by a script that cannot run here, and by unittest of a test
SKIPPED = re.compile(r"^(?:skipped: |.* \.\.\. skipped )(.+)$", re.MULTILINE)
RAN = re.compile(r"^Ran [1-9]\d* tests? in", re.MULTILINE)


def pytest_collect_file(file_path, parent):
    if file_path.suffix == ".test":
        return RosTestFile.from_parent(parent, path=file_path)
    return None


class RosTestFile(pytest.File):
    """One launch file; its set-up is the running system."""

    def collect(self):
        for tag in ElementTree.parse(self.path).getroot().iter("test"):
            yield RosTest.from_parent(self, name=tag.get("test-name"), tag=tag)

    def setup(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addfinalizer(self.folder.cleanup)
        self.host = Host(Path(self.folder.name))
        self.addfinalizer(self.host.close)
        self.system = self.host.start("roslaunch", str(self.path))  # which starts the master, too
        self.host.wait_for_nodes()


class RosTest(pytest.Item):
    """One script of unittests."""

    def __init__(self, *, tag, **more):
        super().__init__(**more)
        (self.script,) = HERE.rglob(tag.get("type"))
        self.limit = float(tag.get("time-limit"))
        self.add_marker(pytest.mark.timeout(self.limit + PATIENCE))  # its own limit ends it first

    def runtest(self):
        words = [sys.executable, str(self.script), "--text", f"__name:={self.name}"]
        if self.parent.system.poll() is not None:
            self.fail("the system ended before this test")
        with tempfile.TemporaryFile("w+", errors="replace") as printed:
            streams = {"stdout": printed, "stderr": subprocess.STDOUT}
            script = start_group(words, env=self.parent.host.environment, **streams)
            try:
                status = script.wait(self.limit)
            except subprocess.TimeoutExpired:
                status = f"no end within {self.limit:g} s"
            finally:
                with suppress(ProcessLookupError):  # it, or what it left behind
                    os.killpg(script.pid, signal.SIGKILL)
                script.wait()
            printed.seek(0)
            said = printed.read()
        skipped = SKIPPED.search(said)
        if status or not (skipped or RAN.search(said)):
            self.fail(f"{said[-SHOWN:]}\nended with: {status}")
        if skipped:
            pytest.skip(skipped[1])

    def fail(self, words):
        raise RosTestError(f"{words}\n--- the system said:\n{self.parent.host.said()[-SHOWN:]}")

    def repr_failure(self, excinfo, style=None):
        if isinstance(excinfo.value, RosTestError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self):
        return self.path, 0, f"rostest {self.name}"


class RosTestError(Exception):
    """A rostest failed, ran nothing or did not end."""
