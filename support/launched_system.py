# SPDX-License-Identifier: BSD-3-Clause
"""Starts and ends the whole system: its own roscore on loopback and the launch files."""

from __future__ import annotations

import os
import random
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path

import rosgraph
import rospy
import yaml
from std_srvs.srv import Trigger

from support.interrupt import undisturbed
from support.process_groups import end_group, start_group

ROOT = Path(__file__).resolve().parent.parent
CONFIG = ROOT / "catkin_ws" / "src" / "rst_control" / "config"
MASTER_PORTS = (20_000, 32_768)  # Linux deals out ports from 32768 on
START_TIME = 60.0  # [s] allowed for roscore to answer
READY_TIME = 90.0  # [s] allowed for all parts to come up


def free_port() -> int:
    """Return a TCP port of the loopback that nobody uses at this moment.

    It is below those that the system deals out, so that no node of another master takes it before
    it is used, and no caller who waits for a master there is connected to itself.
    """
    while True:
        with socket.socket() as probe, suppress(OSError):
            probe.bind(("127.0.0.1", random.randrange(*MASTER_PORTS)))
            return int(probe.getsockname()[1])


class System:
    """One `roslaunch` with a roscore of its own, bound to loopback; context manager."""

    def __init__(self, log: Path, environment: dict[str, str]) -> None:
        port = free_port()
        os.environ["ROS_IP"] = "127.0.0.1"
        for name in ("ROS_HOSTNAME", "ROS_NAMESPACE"):  # of the user's shell: for another system
            os.environ.pop(name, None)
        os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
        os.environ["ROS_LOG_DIR"] = str(log.parent / "ros_logs")
        self._log, self._port = log, port
        self._environment = environment
        self._launches: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> System:
        self._log.parent.mkdir(parents=True, exist_ok=True)
        try:
            self._spawn(["roscore", "-p", str(self._port)])
            deadline = time.monotonic() + START_TIME
            while not _is_up():
                if time.monotonic() > deadline or not self.is_running():
                    raise RuntimeError(f"roscore did not start; see {self._log}")
                time.sleep(0.1)
        except BaseException:
            self.__exit__()
            raise
        return self

    def launch(self, file: Path, **arguments: str | bool | Path) -> None:
        """Start one launch file with its arguments."""
        words = [
            f"{k}:={str(v).lower() if isinstance(v, bool) else v}" for k, v in arguments.items()
        ]
        self._spawn(["roslaunch", "--wait", str(file), *words])

    def launch_session(self, folder: Path, gui: bool = False, **source: str | bool | Path) -> None:
        """Start the whole system on a simulated robot that is recorded into a folder.

        Args:
            folder: Of this session.
            gui: Open the simulator's window.
            source: Further launch arguments, such as where the sound comes from.
        """
        self.launch(
            ROOT / "launch" / "system.launch",
            gui=gui,
            sessions=folder.parent,
            session=folder.name,
            controller_overrides=ROOT / "demo" / "overrides.yaml",
            robot_overrides=ROOT / "demo" / "robot_overrides.yaml",
            **source,
        )

    def launch_kinova(self, folder: Path, gui: bool = False, **source: str | bool | Path) -> None:
        """The same on the strict stand-in of Kinova's and OpenRST's drivers, through the bridge.

        Args:
            folder: Of this session.
            gui: Open the simulator's window.
            source: Further launch arguments, such as where the sound comes from.
        """
        trocar = yaml.safe_load((CONFIG / "scene.yaml").read_text(encoding="utf-8"))["trocar"]
        self.launch(
            ROOT / "launch" / "kinova.launch",
            simulate=True,
            in_air=True,
            dry_run=False,
            speed_scale="1.0",
            **{f"trocar_{axis}": str(value) for axis, value in zip("xyz", trocar, strict=True)},
            limits=CONFIG / "kinova_limits.yaml",
            gui=gui,
            sessions=folder.parent,
            session=folder.name,
            simulation_overrides=ROOT / "demo" / "kinova_robot.yaml",
            bridge_overrides=ROOT / "demo" / "kinova_bridge.yaml",
            controller_overrides=ROOT / "demo" / "kinova_controller.yaml",
            **source,
        )

    def home_tool(self) -> None:
        """Connect and home the simulated tool, as a person does before a session.

        Raises:
            RuntimeError: The service is not there in time, or says why not.
        """
        home = rospy.ServiceProxy("robot/home_tool", Trigger)
        deadline = time.monotonic() + READY_TIME
        why = "nobody offers robot/home_tool"
        while time.monotonic() < deadline and self.is_running():
            try:
                home.wait_for_service(1.0)
                answer = home()
            except rospy.ROSException:
                continue
            if answer.success:
                return
            why = answer.message
            time.sleep(0.5)
        raise RuntimeError(f"the tool was not homed: {why}")

    def wait_for(self, parts: Mapping[str, threading.Event], say: Callable[[str], None]) -> None:
        """Wait until every part has shown that it is ready.

        Args:
            parts: Name of each part, and what is set when it is ready.
            say: Gets the name of each part when it is ready.

        Raises:
            RuntimeError: A node ended, or a part was not ready in time.
        """
        deadline = time.monotonic() + READY_TIME
        for part, ready in parts.items():
            while not ready.wait(0.2):
                if not self.is_running():
                    raise RuntimeError(f"a node ended while the {part} was starting")
                if time.monotonic() > deadline:
                    raise RuntimeError(f"the {part} was not ready within {READY_TIME:g} s")
            say(part)

    def end_launch(self) -> None:
        """End what was launched last, and leave roscore and the rest."""
        with undisturbed():
            end_group(self._launches.pop())

    def pids(self) -> list[int]:
        """Numbers of the processes that were started here: roscore, and each roslaunch."""
        return [process.pid for process in self._launches]

    def is_running(self) -> bool:
        """Tell whether everything that was started is still there."""
        return all(process.poll() is None for process in self._launches)

    def __exit__(self, *_: object) -> None:
        with undisturbed():
            for process in reversed(self._launches):
                end_group(process)

    def _spawn(self, command: list[str]) -> None:
        with self._log.open("ab") as log:
            process = start_group(
                command,
                env={**os.environ, **self._environment},
                stdout=log,
                stderr=subprocess.STDOUT,
                stdin=subprocess.DEVNULL,
            )
        self._launches.append(process)


def _is_up() -> bool:
    """Whether roscore has its own node too: one that is ended before then waits 10 s for it."""
    try:
        return bool(rosgraph.Master("/support").lookupNode("/rosout"))
    except (OSError, rosgraph.MasterException):
        return False
