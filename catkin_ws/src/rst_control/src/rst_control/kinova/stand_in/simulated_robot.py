# SPDX-License-Identifier: BSD-3-Clause
"""Kinova's driver and OpenRST's node on top of the simulated robot, which obeys them alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from rst_control.config import LimitsConfig, SimulatorConfig
from rst_control.kinova.arm_state import ArmReport, SoftLimits
from rst_control.kinova.stand_in.arm import SimulatedArm
from rst_control.kinova.stand_in.config import OpenRstConfig, StandInConfig
from rst_control.kinova.stand_in.driver import KinovaDriver
from rst_control.kinova.stand_in.openrst import OpenRst
from rst_control.kinova.stand_in.torque_sensors import TorqueSensors
from rst_control.kinova.stand_in.waypoints import ArmLimits
from rst_control.robot.backend import RobotBackend
from rst_control.simulation.physics import JointReading
from rst_control.simulation.tissue import SimulatedTissue
from rst_control.types import Setpoint, Vector

ARM = slice(0, 7)
TOOL = slice(7, 10)
AFTER = 0.050  # [s] for which the joints are still led once nothing moves


class Physics(RobotBackend, Protocol):
    """The simulated robot that the drivers lead."""

    tissue: SimulatedTissue

    @property
    def now(self) -> float:
        """Time [s]."""
        ...

    @property
    def target(self) -> Vector:
        """Where the joints should be now [rad]. Shape (10,)."""
        ...

    @property
    def reading(self) -> JointReading:
        """Joints as they are now."""
        ...

    @property
    def fault(self) -> str:
        """Why it takes no set-points; empty: it does."""
        ...


@dataclass(frozen=True, eq=False)
class ArmFeedback:
    """What base_feedback reports of the arm; each of shape (7,)."""

    position: Vector  # [rad], from -pi to pi
    velocity: Vector  # [rad/s]
    effort: Vector  # [N m]


STEP = 0.01  # [rad] that a joint may be sent to from rest at once, as the tool's motors are


class KinovaRobot:
    """Leads the simulated robot by its drivers; call `step` before each step of the robot.

    Args:
        config: Of the drivers.
        limits: With the layers that the arm keeps.
        physics: What moves.

    Raises:
        ConfigError: The layers named are not in limits.yaml.
    """

    def __init__(self, config: StandInConfig, limits: LimitsConfig, physics: Physics) -> None:
        self._physics, self._signs = physics, np.array(config.tool.signs)
        start = physics.target
        self._limits = arm_limits(config, limits)
        arm = SimulatedArm(config.driver, self._limits, start[ARM])
        self.driver = KinovaDriver(config.driver, arm)
        self.tool = OpenRst(config.tool, self._signs * start[TOOL])
        self._torques = TorqueSensors(config.driver.torque)
        self._led_until = -np.inf
        self._silent_until = -np.inf  # [s] while a reply of the arm is waited for
        self._last: ArmFeedback | None = None

    @property
    def is_moving(self) -> bool:
        """Some joint moves, or something waits that may move one."""
        return self.driver.is_moving or self.tool.is_moving

    def step(self) -> None:
        """Let the drivers go on until the present, and lead the joints."""
        physics, arm = self._physics, self.driver.arm
        now = physics.now
        had_fault = bool(arm.fault)
        if physics.fault and not had_fault:
            arm.fail(physics.fault, now)
        self.driver.step(now)
        self.tool.step(now, physics.tissue.is_held)
        if physics.fault:
            if had_fault and not arm.fault:
                self._recover(now)
            return
        if self.is_moving:
            self._led_until = now + AFTER
        if now <= self._led_until:
            physics.servo_jp(self._setpoint(now))

    def lose_reply(self, seconds: float) -> None:
        """Let one reply of the arm be lost: the driver waits, then reports what it had before."""
        self._silent_until = self._physics.now + seconds

    def arm_feedback(self) -> ArmFeedback | None:
        """The arm as its driver reports it; None while it waits for a reply."""
        if self._physics.now < self._silent_until:
            return None
        was_lost, self._silent_until = self._silent_until > -np.inf, -np.inf
        if not was_lost or self._last is None:
            self._last = self._arm_feedback()
        return self._last

    def arm_report(self) -> ArmReport | None:
        """The arm's own state as its driver reports it; None while it waits for a reply."""
        now = self._physics.now
        return None if now < self._silent_until else self.driver.arm.report(now)

    def soft_limits(self) -> SoftLimits:
        """What the arm keeps when speeds lead it."""
        return SoftLimits(self._limits.speed, self._limits.acceleration)

    def _arm_feedback(self) -> ArmFeedback:
        reading = self._physics.reading
        turned = np.mod(reading.position[ARM] + np.pi, 2.0 * np.pi) - np.pi
        velocity = reading.velocity[ARM]
        return ArmFeedback(turned, velocity, self._torques(reading.effort[ARM], velocity))

    def tool_feedback(self) -> Vector | None:
        """Positions of OpenRST [rad] as its node reports them, shape (3,); None: it reports none.

        It never reports a speed, nor an effort: both are 0 in its messages.
        """
        if self.tool.reported is None:
            return None
        if not self.tool.is_homed:
            return np.zeros(3)
        return self._signs * self._physics.reading.position[TOOL]

    def _setpoint(self, now: float) -> Setpoint:
        arm, tool = self.driver.arm, self.tool
        return Setpoint(
            np.concatenate([arm.position, self._signs * tool.position]),
            np.concatenate([arm.velocity, self._signs * tool.velocity]),
            now,
        )

    def _recover(self, now: float) -> None:
        """After ClearFaults: go on from where the joints came to rest."""
        self._physics.clear_fault()
        arm = self.driver.arm
        if self._physics.fault:
            arm.fail(self._physics.fault, now)
            return
        arm.place(self._physics.target[ARM])
        self.tool.position = self._signs * self._physics.target[TOOL]
        self.tool.velocity = np.zeros(3)


def as_driven(config: SimulatorConfig, tool: OpenRstConfig) -> SimulatorConfig:
    """The simulator's settings where drivers lead it: these judge steps; tissue keeps jaws open."""
    return replace(
        config,
        servo=replace(config.servo, start_tolerance=STEP),
        closed_opening=tool.closed_opening,
        held_opening=tool.held_opening,
    )


def arm_limits(config: StandInConfig, limits: LimitsConfig) -> ArmLimits:
    """What the arm keeps, from the two layers that the configuration names.

    Raises:
        ConfigError: limits.yaml has no such layer.
    """
    soft, hard = (limits.named(n) for n in (config.driver.soft_layer, config.driver.hard_layer))
    return ArmLimits(
        lower=np.array(limits.arm_lower),
        upper=np.array(limits.arm_upper),
        speed=np.array(soft.arm_velocity),
        acceleration=np.array(soft.arm_acceleration),
        braking=np.array(hard.arm_acceleration),
    )
