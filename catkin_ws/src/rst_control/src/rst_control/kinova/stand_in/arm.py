# SPDX-License-Identifier: BSD-3-Clause
"""The Gen3's own controller as its driver sees it: calls in, notices out, a course for the joints.

It takes up commands at fixed moments, runs way-points or joint speeds, and slows each joint down by
itself when a stop comes. Speeds last until others come. An emergency stop or a fault latches
until ClearFaults.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

import numpy as np

from rst_control.errors import RstError
from rst_control.kinova.arm_state import ArmReport, ArmState, Banks
from rst_control.kinova.stand_in.config import DriverConfig
from rst_control.kinova.stand_in.joint_ramps import fastest_towards_limits, ramped
from rst_control.kinova.stand_in.waypoints import ArmLimits, Course, Waypoint, objections
from rst_control.types import Vector

log = logging.getLogger("rosout.rst_control.kinova_stand_in")

DRIVER: Final = 1  # connection of the driver
EMERGENCY: Final = Banks(1 << 23)
JOINT_FAULT: Final = Banks(1 << 4)
STILL = 1e-9  # [rad/s] below which a joint stands


class ArmEvent(Enum):
    """What the arm gives notice of (ActionEvent of Kinova's API)."""

    PREPROCESS_START = "preprocess start"
    PREPROCESS_END = "preprocess end"
    START = "start"
    END = "end"
    ABORT = "abort"


@dataclass(frozen=True)
class Notice:
    """Something that happened to the trajectory."""

    event: ArmEvent
    details: str = ""


class ArmMode(Enum):
    """What the arm is doing."""

    HOLDING = "holding"
    PREPROCESSING = "preprocessing"
    TRAJECTORY = "trajectory"
    SPEEDS = "speeds"
    STOPPING = "stopping"


STATES: Final = {
    ArmMode.HOLDING: ArmState.SERVOING_READY,
    ArmMode.PREPROCESSING: ArmState.SERVOING_READY,
    ArmMode.TRAJECTORY: ArmState.SERVOING_PLAYING_SEQUENCE,
    ArmMode.SPEEDS: ArmState.SERVOING_MANUALLY_CONTROLLED,
    ArmMode.STOPPING: ArmState.SERVOING_MANUALLY_CONTROLLED,
}


class ArmRefused(RstError):
    """The arm does not do what it was called for."""


class SimulatedArm:
    """Seven joints and the rules by which they are commanded.

    Args:
        config: Periods and delays.
        limits: Positions, speeds and accelerations that it keeps.
        position: Joints at the start [rad]. Shape (7,).
    """

    def __init__(self, config: DriverConfig, limits: ArmLimits, position: Vector) -> None:
        self._config, self._limits = config, limits
        self.position, self.velocity = np.array(position, dtype=float), np.zeros(len(position))
        self.mode, self.fault = ArmMode.HOLDING, ""
        self._banks = Banks()  # of its base, while it is in fault
        self._by_hand: ArmReport | None = None  # what other hands make it report instead
        self._braking = limits.acceleration
        self._wanted = np.zeros(len(position))
        self._course: Course | None = None
        self._begin = 0.0  # [s] when the preprocessing or the course began
        self._orders: deque[Callable[[float], None]] = deque()
        self._notices: deque[tuple[float, Notice]] = deque()
        self._tick, self._last = -np.inf, -np.inf

    @property
    def is_moving(self) -> bool:
        """Some joint moves or is about to."""
        return self.mode is not ArmMode.HOLDING or bool(self._orders)

    def validate(self, waypoints: Sequence[Waypoint]) -> list[str]:
        """Why it would not run these way-points from where it stands; empty: it would."""
        return objections(self.position, waypoints, self._limits)

    def execute(self, waypoints: Sequence[Waypoint]) -> None:
        """Run way-points.

        Raises:
            ArmRefused: It is at fault, or the way-points are none that it runs.
        """
        if self.fault:
            raise ArmRefused(f"the arm is in fault ({self.fault})")
        if found := self.validate(waypoints):
            raise ArmRefused("; ".join(found))
        self._orders.append(lambda now: self._start(list(waypoints), now))

    def send_speeds(self, speeds: dict[int, float]) -> None:
        """Turn joints, counted from 0, at speeds [rad/s] until others come; the others stand.

        Raises:
            ArmRefused: It is at fault, there is no such joint, or a speed is no number.
        """
        if self.fault:
            raise ArmRefused(f"the arm is in fault ({self.fault})")
        wanted = np.zeros(len(self.position))
        for joint, speed in speeds.items():
            if not 0 <= joint < len(wanted):
                raise ArmRefused(f"joint identifier {joint}, allowed: 0 to {len(wanted) - 1}")
            if not np.isfinite(speed):
                raise ArmRefused(f"speed {speed} of joint identifier {joint} is no finite number")
            wanted[joint] = np.clip(speed, -self._limits.speed[joint], self._limits.speed[joint])
        self._orders.append(lambda now: self._turn(wanted, now))

    def stop(self) -> None:
        """Slow down and stay; what runs is aborted."""
        self._orders.append(self._stop)

    def emergency_stop(self) -> None:
        """Slow down as hard as it can, stay, and take no motion until the faults are cleared."""
        self._orders.append(lambda now: self.fail("emergency stop", now, EMERGENCY))

    def fail(self, reason: str, now: float, banks: Banks = JOINT_FAULT) -> None:
        """Latch a fault; the first reason is kept."""
        if not self.fault:
            log.warning("the arm is in fault: %s", reason)
            self._banks = banks
        self.fault = self.fault or reason
        self._brake(self._limits.braking, f"the arm is in fault: {self.fault}", now)

    def clear_faults(self) -> None:
        """Take motion again."""
        self.fault, self._banks = "", Banks()
        if self._by_hand is not None and self._by_hand.faults:
            self._by_hand = None

    def interfere(self, report: ArmReport, now: float) -> None:
        """What happens at the arm itself: a fault, its web page, a joystick; ready ends it."""
        self._by_hand = None if report.state == ArmState.SERVOING_READY else report
        if report.faults:
            self.fail("; ".join(report.faults), now, report.base)

    def report(self, now: float) -> ArmReport:
        """What it says of itself."""
        if self._by_hand is not None and (self._by_hand.faults or not self.fault):
            return replace(self._by_hand, stamp=now)
        state = ArmState.IN_FAULT if self.fault else STATES[self.mode]
        joints = (Banks(),) * len(self.position)
        return ArmReport(state, DRIVER, now, self._banks, joints)

    def place(self, position: Vector) -> None:
        """Hold where the joints really are [rad], shape (7,); after a fault moved them there."""
        if self.mode is ArmMode.HOLDING:
            self.position = np.array(position, dtype=float)

    def step(self, now: float) -> None:
        """Move on to a time [s], which never goes back."""
        time = 0.0 if np.isinf(self._last) else now - self._last
        self._last = now
        tick = np.floor(now / self._config.command_period + 1e-9)
        if tick > self._tick:
            self._tick = tick
            while self._orders:
                self._orders.popleft()(now)
        if self.mode is ArmMode.PREPROCESSING and now >= self._begin:
            self.mode = ArmMode.TRAJECTORY
        if self.mode is ArmMode.TRAJECTORY and self._course is not None:
            self._follow(self._course, now)
        elif self.mode in (ArmMode.SPEEDS, ArmMode.STOPPING):
            self._move(time)

    def take_notices(self, now: float) -> list[Notice]:
        """Notices that have reached the driver by now."""
        found = []
        while self._notices and self._notices[0][0] <= now:
            found.append(self._notices.popleft()[1])
        return found

    def _notify(self, event: ArmEvent, now: float, details: str = "") -> None:
        self._notices.append((now + self._config.notice_delay, Notice(event, details)))

    def _start(self, waypoints: list[Waypoint], now: float) -> None:
        if self.fault or self.mode is not ArmMode.HOLDING:
            why = self.fault or "the starting point is not where the joints are: they move"
            self._notify(ArmEvent.PREPROCESS_START, now)
            self._notify(ArmEvent.PREPROCESS_END, now)
            self._notify(ArmEvent.ABORT, now, why)
            return
        config = self._config
        self._course = Course(self.position, waypoints)
        self._begin = now + config.preprocess_time + config.preprocess_point * len(waypoints)
        self.mode = ArmMode.PREPROCESSING
        self._notify(ArmEvent.PREPROCESS_START, now)
        both = [ArmEvent.PREPROCESS_END, ArmEvent.START]
        for event in reversed(both) if config.swapped_notices else both:
            self._notify(event, self._begin)

    def _turn(self, wanted: Vector, now: float) -> None:
        if self.fault:
            return
        self._abort("another command was sent", now)
        self._wanted, self.mode = wanted, ArmMode.SPEEDS

    def _stop(self, now: float) -> None:
        self._brake(self._limits.acceleration, "the arm was asked to stop", now)

    def _brake(self, deceleration: Vector, why: str, now: float) -> None:
        self._abort(why, now)
        is_harder = self.mode is ArmMode.STOPPING and bool((deceleration < self._braking).any())
        self._braking = self._braking if is_harder else deceleration
        self._wanted = np.zeros(len(self.position))
        self.mode = ArmMode.STOPPING

    def _abort(self, why: str, now: float) -> None:
        if self.mode not in (ArmMode.PREPROCESSING, ArmMode.TRAJECTORY):
            return
        self._course = None
        self._notices = deque(n for n in self._notices if n[0] <= now + self._config.notice_delay)
        self._notify(ArmEvent.ABORT, now, why)

    def _follow(self, course: Course, now: float) -> None:
        self.position, self.velocity = course.at(now - self._begin)
        if now - self._begin >= course.duration:
            self.mode, self._course = ArmMode.HOLDING, None
            self._notify(ArmEvent.END, now)

    def _move(self, time: float) -> None:
        limits, is_stopping = self._limits, self.mode is ArmMode.STOPPING
        most = self._braking if is_stopping else limits.acceleration
        low, high = fastest_towards_limits(self.position, limits.lower, limits.upper, most, time)
        wanted = np.clip(self._wanted, low, high)
        before = self.velocity
        self.velocity = ramped(before, wanted, most, time)
        position = self.position + 0.5 * (before + self.velocity) * time
        self.position = np.clip(position, limits.lower, limits.upper)
        if not self._wanted.any() and np.abs(self.velocity).max() <= STILL:
            self.velocity, self.mode = np.zeros_like(before), ArmMode.HOLDING
