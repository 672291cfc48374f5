# SPDX-License-Identifier: BSD-3-Clause
"""A process that keeps the robot at work, and tells the control loop's totals when it is asked."""

from __future__ import annotations

import json
import sys
import threading
import time

import rospy
from diagnostic_msgs.msg import DiagnosticArray

from rst_control.msg import ControllerState
from rst_control.srv import Command

START_TIME = 60.0  # [s] allowed for the controller to start
ANSWER_TIME = 10.0  # [s] allowed for its next diagnostics
COMMANDS = ("hey robot", "tense", "pull more", "pull less", "release")


class ProcessWatcher:
    """Keeps the newest state and diagnostics of the controller."""

    def __init__(self) -> None:
        self._state = ""
        self._totals: dict[str, float] = {}
        self._news = threading.Event()
        self._subscribers = [
            rospy.Subscriber("rst_control/state", ControllerState, self._on_state),
            rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics),
        ]

    def totals(self) -> dict[str, float]:
        """Totals of the control loop from now.

        Raises:
            RuntimeError: The controller publishes no diagnostics.
        """
        self._news.clear()
        if not self._news.wait(ANSWER_TIME):
            raise RuntimeError("the controller publishes no diagnostics")
        return self._totals

    def work(self) -> None:
        """Give one command after the other, each at rest."""
        command, said = rospy.ServiceProxy("rst_control/command", Command), 0
        while not rospy.is_shutdown():
            if self._state not in ("", "moving", "stopping"):
                command(COMMANDS[said % len(COMMANDS)])
                said += 1
            time.sleep(0.3)

    def _on_state(self, message: ControllerState) -> None:
        self._state = message.state

    def _on_diagnostics(self, array: DiagnosticArray) -> None:
        for status in array.status:
            if status.name == "rst_control: control loop":
                values = {entry.key: entry.value for entry in status.values}
                total = int(values["ticks"]) + int(values["skipped ticks"])
                late = float(values["late ticks [%]"]) / 100.0 * total
                self._totals = {"total": total, "late": late}
                self._news.set()


def main() -> None:
    """Answer each line of the input with one of the output."""
    rospy.init_node("watcher", disable_signals=True)
    rospy.wait_for_service("rst_control/command", START_TIME)
    watcher = ProcessWatcher()
    threading.Thread(target=watcher.work, daemon=True).start()
    for _ in sys.stdin:
        print(json.dumps(watcher.totals()), flush=True)


if __name__ == "__main__":
    main()
