# SPDX-License-Identifier: BSD-3-Clause
"""The parts of a running system, each a launch of its own that can be lost and started anew."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from xmlrpc.client import ServerProxy

import rosgraph

from rst_control.host.respawn import MOST, PAUSE, SPAN
from support.figures import ROOT
from support.launched_system import free_port
from support.process_groups import STOP_TIME, start_group
from support.waiting import wait_until

START_TIME = 60.0  # [s] for a part to come up
DELAY = 10.0  # [s] at most between the signal of a crash and the crash
SIGNALS = {  # by which a part is lost; the last two mean something to losses/voice.py alone
    "SIGKILL": signal.SIGKILL,
    "SIGSTOP": signal.SIGSTOP,
    "hang": signal.SIGUSR1,
    "crash": signal.SIGUSR2,
}


@dataclass(frozen=True)
class StartPlan:
    """How a part is started."""

    node: str  # its name; empty for the master
    command: tuple[str, ...]
    is_kept: bool = False  # it is started anew by itself where it crashes


class Part:
    """One launch, and the process in it that does the work.

    Args:
        plan: How it is started.
        log: File that takes what it says.
    """

    def __init__(self, plan: StartPlan, log: Path) -> None:
        self._plan, self._log = plan, log
        self._launch: subprocess.Popen[bytes] | None = None
        self.pid = 0  # of the process that does the work
        self._lost = 0.0  # [s] when
        self._ends: deque[float] = deque(maxlen=MOST)  # [s] of its process, in this launch

    def start(self) -> None:
        """Start it and wait until its process is known.

        Raises:
            RuntimeError: It did not come up.
        """
        with self._log.open("ab") as log:
            self._launch = start_group(
                self._plan.command,
                stdout=log,
                stderr=subprocess.STDOUT,
                stdin=subprocess.DEVNULL,
            )
        self._ends.clear()
        before, self.pid = self.pid, 0
        wait_until(lambda: self._find(before), f"{self._plan.command[-1]} started", START_TIME)

    def lose(self, way: str) -> float:
        """Send the signal of a way; gives when [s], time.monotonic()."""
        moment = self._lost = time.monotonic()
        os.kill(self.pid, SIGNALS[way])
        if way in {"SIGKILL", "crash"}:
            self._ends.append(moment)
        return moment

    def give_back(self, way: str) -> float:
        """Let it go on, or be started anew; gives the earliest moment of that [s]."""
        if way == "SIGSTOP":
            moment = time.monotonic()
            os.kill(self.pid, signal.SIGCONT)
            return moment
        if self._plan.is_kept and not self._is_given_up(way):
            if way == "hang":
                self._lost = time.monotonic()
                self._ends.append(self._lost)
                os.kill(self.pid, signal.SIGKILL)
            before, moment = self.pid, self._lost + PAUSE
            wait_until(lambda: self._find(before) and self.pid != before, "kept", START_TIME)
            return moment
        self.end()  # what its launch has beside it goes, too
        moment = time.monotonic()
        self.start()
        return moment

    def _is_given_up(self, way: str) -> bool:
        """It ended so often, or would by this, that its keeper ends the whole launch."""
        ends = [*self._ends, time.monotonic()] if way == "hang" else [*self._ends]
        return len(ends) >= MOST and ends[-1] - ends[-MOST] < SPAN + DELAY

    def end(self) -> None:
        """End the launch and all that it started."""
        launch, self._launch = self._launch, None
        if launch is None:
            return
        with suppress(ProcessLookupError):
            os.kill(self.pid or launch.pid, signal.SIGCONT)
        if launch.poll() is None:
            launch.send_signal(signal.SIGINT)
            try:
                launch.wait(STOP_TIME)
            except subprocess.TimeoutExpired:
                with suppress(ProcessLookupError):
                    os.kill(self.pid or launch.pid, signal.SIGKILL)  # a group of its own
                os.killpg(launch.pid, signal.SIGKILL)
                launch.wait()

    def _find(self, before: int) -> bool:
        if self._launch is None or self._launch.poll() is not None:
            raise RuntimeError(f"{self._plan.command} ended; see {self._log}")
        found = self._node_pid() if self._plan.node else self._master_pid()
        if found and found != before:
            self.pid = found
        return bool(self.pid)

    def _node_pid(self) -> int:
        try:
            api = rosgraph.Master("/losses").lookupNode(self._plan.node)
            with ServerProxy(api) as node:
                reply = node.getPid("/losses")
        except (OSError, rosgraph.MasterException):
            return 0
        return int(reply[2]) if isinstance(reply, list) else 0

    def _master_pid(self) -> int:
        if self._launch is None or not rosgraph.is_master_online():
            return 0
        for pid in _children(self._launch.pid):
            words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
            if any(word.endswith(b"rosmaster") for word in words):
                return pid
        return 0


class Parts:
    """A master and the parts around it; a context manager.

    Args:
        folder: For what ROS writes.
        log: File that takes what the parts say.
    """

    def __init__(self, folder: Path, log: Path) -> None:
        port = free_port()
        os.environ["ROS_IP"] = "127.0.0.1"
        os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
        os.environ["ROS_LOG_DIR"] = str(folder / "ros_logs")
        self._log = log
        self._parts = {"roscore": self._part(StartPlan("", ("roscore", "-p", str(port))))}

    def __enter__(self) -> Parts:
        self["roscore"].start()
        return self

    def __exit__(self, *_: object) -> None:
        for part in reversed(self._parts.values()):
            part.end()

    def __getitem__(self, name: str) -> Part:
        return self._parts[name]

    def launch(self, name: str, node: str, file: str, **arguments: str | Path) -> None:
        """Start a part by one launch file with its arguments."""
        words = [f"{key}:={value}" for key, value in arguments.items()]
        command = ("roslaunch", "--wait", str(ROOT / "launch" / file), *words)
        self._start(name, StartPlan(node, command, is_kept=name != "recorder"))

    def run(self, name: str, node: str, command: tuple[str, ...]) -> None:
        """Start a part by a command, as the launch files do."""
        self._start(
            name, StartPlan(node, ("rosrun", "rst_control", "respawn", *command), is_kept=True)
        )

    def _start(self, name: str, plan: StartPlan) -> None:
        self._parts[name] = self._part(plan)
        self._parts[name].start()

    def _part(self, plan: StartPlan) -> Part:
        return Part(plan, self._log)


def _children(pid: int) -> list[int]:
    words = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()
    return [int(word) for word in words]
