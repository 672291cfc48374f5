# SPDX-License-Identifier: BSD-3-Clause
"""Kinova's driver: what comes in by ROS waits for its one thread, which calls the arm."""

from __future__ import annotations

import logging
from collections.abc import Callable

from rst_control.kinova.stand_in.arm import ArmRefused, SimulatedArm
from rst_control.kinova.stand_in.callback_thread import CallbackThread, Work
from rst_control.kinova.stand_in.config import DriverConfig
from rst_control.kinova.stand_in.goals import GoalHandle
from rst_control.kinova.stand_in.trajectory_server import TrajectoryServer

log = logging.getLogger("rosout.rst_control.kinova_stand_in")


class KinovaDriver:
    """Takes goals and messages; `step` lets the driver and the arm go on.

    Args:
        config: Of the driver.
        arm: Behind it.
    """

    def __init__(self, config: DriverConfig, arm: SimulatedArm) -> None:
        self._config, self.arm = config, arm
        self.server = TrajectoryServer(config, arm)
        self._thread = CallbackThread()

    @property
    def is_moving(self) -> bool:
        """The arm moves, or something waits that may move it."""
        return self.arm.is_moving or self._thread.is_busy

    def take_goal(self, goal: GoalHandle) -> None:
        """A new goal of FollowJointTrajectory."""
        self._thread.post("goal", lambda: self.server.take(goal), keep_all=True)

    def take_cancel(self) -> None:
        """A goal was asked to be cancelled; its handle knows that already."""
        self._thread.post("cancel", self.server.take_cancel, keep_all=True)

    def take_stop(self) -> None:
        """`in/stop`."""
        calls = self._config.calls
        self._thread.post("stop", lambda: self._call("stop", self.arm.stop, calls.stop))

    def take_emergency_stop(self) -> None:
        """`in/emergency_stop`."""
        calls, stop = self._config.calls, self.arm.emergency_stop
        self._thread.post("emergency", lambda: self._call("emergency_stop", stop, calls.stop))

    def take_clear_faults(self) -> None:
        """`in/clear_faults`."""
        time, clear = self._config.calls.clear_faults, self.arm.clear_faults
        self._thread.post("clear", lambda: self._call("clear_faults", clear, time))

    def take_speeds(self, speeds: dict[int, float]) -> None:
        """`in/joint_velocity`: speeds [rad/s] of joints counted from 0."""
        time = self._config.calls.speeds

        def send() -> None:
            self.arm.send_speeds(speeds)

        self._thread.post("speeds", lambda: self._call("joint_velocity", send, time))

    def step(self, now: float) -> None:
        """Let the driver and the arm go on until a time [s], which never goes back."""
        self.server.now = now
        for notice in self.arm.take_notices(now):
            self.server.hear(notice)
        self._thread.advance(now)
        self.arm.step(now)

    def _call(self, name: str, call: Callable[[], None], time: float) -> Work:
        try:
            call()
        except ArmRefused as error:
            log.warning("in/%s: %s", name, error)
        yield time
