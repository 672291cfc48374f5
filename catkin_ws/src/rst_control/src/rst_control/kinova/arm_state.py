# SPDX-License-Identifier: BSD-3-Clause
"""What the arm says of itself: its state, its faults by name, who is in control, its soft limits.

Numbers and names are those of Kinova's API (Common.ArmState, Base.SafetyIdentifier,
ActuatorConfig.SafetyIdentifier). Bits of the banks B are published nowhere and keep their numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np

from rst_control.kinova.config import ArmConfig
from rst_control.types import Cause, Reason, Vector

LIMITS_SERVICE: Final = "control_config/get_kinematic_soft_limits"
FIRMWARE_SERVICE: Final = "base/get_firmware_bundle_versions"
SPEEDS_MODE: Final = 1  # ControlConfig.ControlMode ANGULAR_JOYSTICK: joint speeds
MOST_OVER: Final = 1.2  # [-] times `arm.acceleration` that the arm's own limit may be
BEGINS: Final = 0.25  # [s] for velocities to put the arm under the driver's control
ROUNDING: Final = 0.005  # [rad/s], [rad/s^2] by which a limit may be short: it is set in degrees


class ArmState(IntEnum):
    """Common.ArmState."""

    UNSPECIFIED = 0
    BASE_INITIALIZATION = 1
    IDLE = 2
    INITIALIZATION = 3
    IN_FAULT = 4
    MAINTENANCE = 5
    SERVOING_LOW_LEVEL = 6
    SERVOING_READY = 7
    SERVOING_PLAYING_SEQUENCE = 8
    SERVOING_MANUALLY_CONTROLLED = 9  # joint speeds do this, too


BASE_FAULTS: Final = (  # by bit of bank A, from the lowest
    "firmware update failure",
    "external communication error",
    "maximum ambient temperature",
    "maximum core temperature",
    "joint fault",
    "cyclic data jitter",
    "maximum of event logs",
    "no kinematics support",
    "too many joints",
    "network error",
    "unable to reach pose",
    "joint detection error",
    "network initialization error",
    "maximum current",
    "maximum voltage",
    "minimum voltage",
    "maximum tool translation velocity",
    "maximum tool rotation velocity",
    "maximum tool translation acceleration",
    "maximum tool rotation acceleration",
    "maximum tool force",
    "maximum tool torque",
    "maximum payload",
    "emergency stop",
    "emergency line",
    "inrush current limiter",
    "memory corrupted",
    "incompatible firmware version",
    "power-on self test failure",
)
JOINT_FAULTS: Final = (
    "following error",
    "maximum velocity",
    "upper joint limit",
    "lower joint limit",
    "strain gauge mismatch",
    "maximum torque",
    "unreliable absolute position",
    "magnetic position sensor",
    "Hall position sensor",
    "Hall sequence",
    "encoder and Hall sensor differ",
    "encoder index",
    "encoder and magnetic sensor differ",
    "maximum motor current",
    "motor current mismatch",
    "maximum voltage",
    "minimum voltage",
    "maximum motor temperature",
    "maximum core temperature",
    "memory corrupted",
    "motor driver",
    "emergency line",
    "communication lost",
    "watchdog",
)
HELD_BY_OTHERS: Final = (
    ArmState.SERVOING_PLAYING_SEQUENCE,
    ArmState.SERVOING_MANUALLY_CONTROLLED,
    ArmState.SERVOING_LOW_LEVEL,
)


@dataclass(frozen=True)
class Banks:
    """Two banks of bits."""

    a: int = 0
    b: int = 0

    def names(self, known: tuple[str, ...]) -> list[str]:
        """Each bit by its name, or by its number."""
        a = [
            known[bit] if bit < len(known) else f"bank A bit {bit}"
            for bit in range(32)
            if self.a >> bit & 1
        ]
        return a + [f"bank B bit {bit}" for bit in range(32) if self.b >> bit & 1]


@dataclass(frozen=True)
class ArmReport:
    """One state of the arm."""

    state: int  # of ArmState, or a number that is none
    connection: int  # whose command last changed the state
    stamp: float  # [s] steady clock, when it arrived
    base: Banks = Banks()
    joints: tuple[Banks, ...] = ()  # from the base on
    wrist: Banks = Banks()  # the interface module
    warnings: tuple[str, ...] = ()  # by name; they stop nothing

    @property
    def state_name(self) -> str:
        """In words."""
        known = {state.value: state.name for state in ArmState}
        return known.get(self.state, f"state {self.state}").lower().replace("_", " ")

    @property
    def faults(self) -> list[str]:
        """All by name, with the part that has them."""
        return named(self.base, self.joints, self.wrist)

    def objection(self) -> Cause | None:
        """Why an arm that nobody leads may not be led; None: it may."""
        if self.faults or self.state == ArmState.IN_FAULT:
            words = "; ".join(self.faults) or "it names none"
            return Cause(Reason.ARM_FAULT, f"the arm is in fault: {words}; allowed: no fault")
        if self.state == ArmState.SERVOING_READY:
            return None
        if self.state in HELD_BY_OTHERS:
            words = f"somebody else controls the arm: {self.state_name}, by connection"
            return Cause(Reason.ARM_IN_USE, f"{words} {self.connection}; allowed: nobody")
        words = f"the arm is not ready: {self.state_name}, allowed: servoing ready"
        return Cause(Reason.ARM_NOT_READY, words)


def named(base: Banks, joints: tuple[Banks, ...], wrist: Banks) -> list[str]:
    """Bits of all parts by name, with the part in front."""
    found = [f"base: {name}" for name in base.names(BASE_FAULTS)]
    for joint, banks in enumerate(joints, 1):
        found += [f"joint_{joint}: {name}" for name in banks.names(JOINT_FAULTS)]
    return found + [f"wrist: {name}" for name in wrist.names(())]


@dataclass(frozen=True)
class SoftLimits:
    """What the arm keeps while joint speeds lead it; each of shape (7,)."""

    speed: Vector  # [rad/s]
    acceleration: Vector  # [rad/s^2]

    def objection(self, config: ArmConfig, speed: Vector) -> Cause | None:
        """Which limit is too low for what is planned.

        Args:
            config: With the accelerations that the bridge counts on.
            speed: Of the plans, at most [rad/s]. Shape (7,).
        """
        wanted = (
            ("speed", "rad/s", self.speed, speed),
            ("acceleration", "rad/s2", self.acceleration, np.array(config.acceleration)),
        )
        for what, unit, has, needs in wanted:
            if has.shape != needs.shape or not np.isfinite(has).all():
                words = f"the arm's soft limits of joint {what} are {has.tolist()}"
                return Cause(Reason.ARM_LIMITS, f"{words}, allowed: 7 numbers")
            short = np.flatnonzero(has < needs - ROUNDING)
            if len(short):
                joint = int(short[0])
                return Cause(
                    Reason.ARM_LIMITS,
                    f"the arm's soft limit of the {what} of {config.joints[joint]} is "
                    f"{has[joint]:.2f} {unit}, needed at least {needs[joint]:.2f}",
                )
        over = np.flatnonzero(self.acceleration > MOST_OVER * np.array(config.acceleration))
        if len(over):  # a joint that changes its speed sooner leaves the common way
            joint, known = int(over[0]), config.acceleration[over[0]]
            return Cause(
                Reason.ARM_LIMITS,
                f"the arm's soft limit of the acceleration of {config.joints[joint]} is "
                f"{self.acceleration[joint]:.2f} rad/s2, allowed {known:.2f} to "
                f"{MOST_OVER * known:.2f}; or set arm.acceleration to what it is",
            )
        return None


class ArmWatch:
    """Judges the newest state of the arm; one thread calls it.

    Joint speeds put the arm under manual control, as a joystick or the web page does. The
    connection that gets it while the bridge begins to lead the arm, or moves it, is taken as the
    driver's own.

    Args:
        config: Names and times.
        speed: Of the plans, at most [rad/s]. Shape (7,).
    """

    def __init__(self, config: ArmConfig, speed: Vector) -> None:
        self._config, self._speed = config, speed
        self.report: ArmReport | None = None
        self.limits: SoftLimits | None = None
        self._own: int | None = None  # connection of the driver, once it is known
        self._begun = self._led = -np.inf  # [s] since when and until when the bridge led the arm

    def update(self, report: ArmReport, is_led: bool, is_moved: bool = False) -> Cause | None:
        """Take in a state; why it latches; None: it does not, or did so before.

        Args:
            report: The new one.
            is_led: The bridge leads the arm, or stops it.
            is_moved: It sends it speeds that are not zero.
        """
        before = self._objection(self.report) if self.report is not None else None
        if self.report is not None and report.stamp - self.report.stamp > self._config.state_age:
            self._own = self.limits = None  # the driver was started anew, perhaps
        if is_led:
            self._note_led(report, is_moved)
        self.report = report
        cause = self._objection(report)
        is_new = before is None or cause is None or before.reason is not cause.reason
        latches = cause is not None and cause.reason is not Reason.ARM_NOT_READY
        return cause if is_new and latches else None

    def objection(self, now: float) -> Cause | None:
        """Why the arm may not be led at a time [s]; None: it may."""
        config, report = self._config, self.report
        if config.reports_state:
            topic = f"{config.namespace}/base_feedback"
            if report is None:
                words = f"the arm never reported its state on {topic}; a driver without it needs "
                return Cause(Reason.ARM_NOT_READY, words + "bridge.arm.reports_state: false")
            if (age := now - report.stamp) > config.state_age:
                words = f"the arm's state is {age:.2f} s old, allowed {config.state_age:g} s"
                return Cause(Reason.ARM_NOT_READY, f"{words} ({topic})")
            if (cause := self._objection(report)) is not None:
                return cause
        if not config.reports_limits:
            return None
        if self.limits is None:
            words = "the arm's soft limits are not read yet"
            return Cause(Reason.ARM_LIMITS, f"{words} ({config.namespace}/{LIMITS_SERVICE})")
        return self.limits.objection(config, self._speed)

    @property
    def has_fault(self) -> bool:
        """The arm's newest state is a fault."""
        cause = None if self.report is None else self._objection(self.report)
        return cause is not None and cause.reason is Reason.ARM_FAULT

    @property
    def words(self) -> dict[str, str]:
        """What is known of the arm, for people and for the recording."""
        report, limits = self.report, self.limits
        found = {"arm: state": "never reported" if report is None else report.state_name}
        if report is not None:
            found["arm: in control"] = f"connection {report.connection}"
            found["arm: faults"] = "; ".join(report.faults) or "none"
            found["arm: warnings"] = "; ".join(report.warnings) or "none"
        if limits is not None:
            found["arm: soft speed [rad/s]"] = _row(limits.speed)
            found["arm: soft acceleration [rad/s^2]"] = _row(limits.acceleration)
        return found

    def _objection(self, report: ArmReport) -> Cause | None:
        return None if self._is_ours(report) else report.objection()

    def _note_led(self, report: ArmReport, is_moved: bool) -> None:
        now = report.stamp
        if now - self._led > BEGINS:  # it begins: whose connection it is shows each time anew
            self._begun, self._own = now, None
        self._led = now
        is_speeds = report.state == ArmState.SERVOING_MANUALLY_CONTROLLED
        if is_speeds and self._own is None and (is_moved or now - self._begun <= BEGINS):
            self._own = report.connection

    def _is_ours(self, report: ArmReport) -> bool:
        """Velocities of the bridge itself have it."""
        is_recent = report.stamp - self._led <= self._config.settle_time
        is_speeds = report.state == ArmState.SERVOING_MANUALLY_CONTROLLED and not report.faults
        return is_speeds and is_recent and report.connection == self._own


def _row(values: Vector) -> str:
    return " ".join(f"{value:.2f}" for value in values)
