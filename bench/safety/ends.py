# SPDX-License-Identifier: BSD-3-Clause
"""Does Ctrl-C end simulator and controller, at any moment of their start and after it?

Both are started and ended again and again on one master. Moments are spread evenly over the first
seconds. No state that the controller publishes may be from before its start. In the environment:
TURNS (50).
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from pathlib import Path

import rospy

from bench.common.resumable import measured
from rst_control.msg import ControllerState
from support.figures import ROOT, Figure
from support.launched_system import System
from support.process_groups import end_group
from support.waiting import wait_until

FULL = 50
TURNS = int(os.environ.get("TURNS", FULL))
FILES = [str(ROOT / "launch" / name) for name in ("robot.launch", "controller.launch")]
STARTED = ("process[robot-", "process[controller-")  # printed by roslaunch
SPAN = 6.0  # [s] after that; a start takes four
START_TIME = 60.0  # [s] allowed for roslaunch to read its files
ALLOWED = 5.0  # [s]; roslaunch gives a node 15 s, and then kills it
AGE = 60.0  # [s] of a state from before the start; the machine has run longer
ESCALATION = "escalating to"  # printed by roslaunch then


def measure() -> list[Figure]:
    """Start and end both, and count what took long."""
    ages: list[float] = []  # [s] of the states, when they came
    with tempfile.TemporaryDirectory() as name, System(Path(name) / "master.log", {}):
        rospy.init_node("ends", anonymous=True, disable_signals=True)
        rospy.Subscriber("rst_control/state", ControllerState, lambda m: ages.append(_age(m)))
        ends = [_end_after(SPAN * k / TURNS, Path(name) / f"{k}.log") for k in range(TURNS)]
        logs = "".join(log.read_text() for log in Path(name).glob("[0-9]*.log"))
        for k, took in enumerate(ends):
            if took > ALLOWED:
                print(f"{took:.1f} s:", (Path(name) / f"{k}.log").read_text())
    seen = f"(of {len(ages)})"
    note = f"(SIGINT within {SPAN:g} s of the start)"
    return [
        measured(TURNS, "starts and ends", FULL),
        Figure("until simulator and controller end, longest", max(ends), "s", ALLOWED, note=note),
        Figure("until simulator and controller end, mean", sum(ends) / TURNS, "s"),
        Figure("nodes that had to be killed", logs.count(ESCALATION), "", 0.0),
        Figure("states from before the start", sum(a > AGE for a in ages), "", 0.0, note=seen),
    ]


def _age(state: ControllerState) -> float:
    return float((rospy.Time.now() - state.header.stamp).to_sec())


def _end_after(delay: float, log: Path) -> float:
    """Time that both take to end [s], asked to so long [s] after their processes have begun."""
    with log.open("wb") as file:
        launch = subprocess.Popen(
            ["roslaunch", *FILES], stdout=file, stderr=subprocess.STDOUT, start_new_session=True
        )
    try:
        wait_until(lambda: all(s in log.read_text() for s in STARTED), "both nodes", START_TIME)
        time.sleep(delay)
    finally:
        asked = time.monotonic()
        end_group(launch)
    return time.monotonic() - asked
