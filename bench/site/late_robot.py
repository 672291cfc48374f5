# SPDX-License-Identifier: BSD-3-Clause
"""A robot whose commands and feedback come late."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from rst_control.config.plant import LatenessConfig
from rst_control.robot.backend import RobotBackend
from rst_control.simulation.plant.lateness import LateQueue
from rst_control.types import Measurement, Setpoint

EARLY = 1e-9  # [s] by which a time may be rounded


class Clocked(RobotBackend, Protocol):
    """A robot with a clock."""

    @property
    def now(self) -> float:
        """Time [s]."""
        ...


class LateRobot(RobotBackend):
    """A robot behind messages that come late. `deliver` has to be called at each of its steps.

    Args:
        robot: What is commanded and measured.
        config: Delays.
        period: Between two measurements that the robot sends [s].
        seed: Of the jitter.
    """

    def __init__(self, robot: Clocked, config: LatenessConfig, period: float, seed: int) -> None:
        self._robot, random = robot, np.random.default_rng(seed)
        self._period, self._due = period, robot.now
        self._commands: LateQueue[Setpoint | None] = LateQueue(
            config.command_delay, config.command_jitter, random
        )
        self._feedback: LateQueue[Measurement] = LateQueue(
            config.feedback_delay, config.feedback_jitter, random
        )
        self._measured: Measurement | None = None

    def deliver(self) -> None:
        """Hand commands that have arrived to the robot, and send what it measures now."""
        now = self._robot.now
        for command in self._commands.take(now):
            if command is None:
                self._robot.hold()
            else:
                self._robot.servo_jp(command)
        measured = self._robot.measured_js() if now >= self._due - EARLY else None
        if measured is not None:
            self._due += self._period
            self._feedback.put(measured, now)
        for measured in self._feedback.take(now):
            self._measured = replace(measured, stamp=now, sent=measured.stamp)

    def measured_js(self) -> Measurement | None:
        """The newest measurement that has arrived, stamped when it did."""
        return self._measured

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Send a set-point."""
        self._commands.put(setpoint, self._robot.now)

    def hold(self) -> None:
        """Send that it is to slow down and stay."""
        self._commands.put(None, self._robot.now)

    def clear_fault(self) -> None:
        """Ask at once."""
        self._robot.clear_fault()
