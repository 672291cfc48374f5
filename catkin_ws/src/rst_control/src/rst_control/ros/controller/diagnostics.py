# SPDX-License-Identifier: BSD-3-Clause
"""The controller's health on `/diagnostics`, once a second."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from rst_control.execution.loop_statistics import LoopSummary
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.ros.controller.messages import code_of
from rst_control.types import LATCHED

LATE_WARNING = 1.0  # [%] of ticks late, above which the loop is reported
ERRORS_SHOWN = 3  # of the newest errors in threads
SHOWN_FOR = 60.0  # [s] for which an error counts


class Diagnostics:
    """Collects and publishes what a person needs to see that all is well, or why not."""

    def __init__(self) -> None:
        self.priority = "none"  # what the system granted the node, in words
        self._publisher = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=1)
        self._errors: list[tuple[float, str]] = []  # [s] when, and what

    def error(self, words: str) -> None:
        """Note an error in one of the threads."""
        self._errors = [*self._errors, (time.monotonic(), words)][-ERRORS_SHOWN:]

    def publish(
        self,
        view: ControllerSnapshot,
        loop: LoopSummary,
        objection: str,
        command_age: float,
        places: Mapping[str, str],
        others: Sequence[DiagnosticStatus],
    ) -> None:
        """Publish one report.

        Args:
            view: The executor's state.
            loop: How the control loop keeps its times.
            objection: What is wrong with the robot's messages; empty: nothing.
            command_age: Time since the last command came [s].
            places: Trocar and grasp point that count, in words.
            others: Whether what happens is recorded, and who publishes unasked.
        """
        robot = self._robot(view, objection, command_age, places)
        array = DiagnosticArray(status=[robot, self._loop(loop), *others])
        array.header.stamp = rospy.Time.now()
        self._publisher.publish(array)

    def _robot(
        self,
        view: ControllerSnapshot,
        objection: str,
        command_age: float,
        places: Mapping[str, str],
    ) -> DiagnosticStatus:
        level, message = DiagnosticStatus.OK, view.mode.state.value
        if view.mode.state in LATCHED:
            level = DiagnosticStatus.WARN
            message = f'{message}: {view.mode.reason}; say "hey robot" to go on'
        if view.health is not None:
            level, message = DiagnosticStatus.ERROR, view.health.words
        measured = view.measurement
        values = {
            "reason_code": code_of(view.health or view.latch),
            "state": view.mode.state.value,
            "phase": view.phase,
            "rcm error [um]": f"{view.rcm_error * 1e6:.1f}",
            **places,
            "tension [N]": f"{view.tension:.3f}",
            "tension not trusted": measured.tension_invalid_reason if measured else "",
            "last command [s ago]": f"{command_age:.1f}",
            "last refusal": view.last_refusal.words if view.last_refusal else "",
            "messages of the robot": objection or "good",
        }
        return make_status("motion", level, message, values)

    def _loop(self, loop: LoopSummary) -> DiagnosticStatus:
        level, message = DiagnosticStatus.OK, "on time"
        if loop.late_percent > LATE_WARNING:
            level, message = DiagnosticStatus.WARN, f"{loop.late_percent:.2f} % of ticks late"
        since = time.monotonic() - SHOWN_FOR
        errors = [words for when, words in self._errors if when >= since]
        if errors:
            level, message = DiagnosticStatus.ERROR, errors[-1]
        values = {
            "ticks": str(loop.ticks),
            "late ticks [%]": f"{loop.late_percent:.3f}",
            "skipped ticks": str(loop.skipped),
            "tick p50 [us]": f"{loop.duration_p50 * 1e6:.0f}",
            "tick p99 [us]": f"{loop.duration_p99 * 1e6:.0f}",
            "lateness p99 [us]": f"{loop.lateness_p99 * 1e6:.0f}",
            "priority": self.priority,
            "errors": "; ".join(errors) or "none",
        }
        return make_status("control loop", level, message, values)


def make_status(name: str, level: int, message: str, values: dict[str, str]) -> DiagnosticStatus:
    """Put one status of the controller together."""
    return DiagnosticStatus(
        level=level,
        name=f"rst_control: {name}",
        message=message,
        hardware_id="controller",
        values=[KeyValue(key, value) for key, value in values.items()],
    )
