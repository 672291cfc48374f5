# SPDX-License-Identifier: BSD-3-Clause
"""kinova_bridge.yaml: how set-points become commands of the drivers, and what is checked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from rst_control.config import CONFIG_FOLDER, LimitsConfig, SceneConfig
from rst_control.config.believed import BridgeBelievedConfig
from rst_control.config.simulator import ServoConfig
from rst_control.config.torque_tension import (
    TORQUE_TENSION_FILE,
    TorqueTensionConfig,
    load_torque_tension,
)
from rst_control.robot.setpoint_servo import ServoLimits
from rst_control.types import ARM_COUNT, JOINTS, Arm, Triple
from typed_config import choice, flag, load_file, number, require, text
from typed_config.node_names import require_names

TOOL_COUNT = 3  # joints of OpenRST: pitch, left jaw, right jaw
BEAT_PERIOD = 0.02  # [s] at most, between two beats of the bridge for its guard


@dataclass(frozen=True, kw_only=True)
class ArmConfig:
    """The arm's driver, and how its joints are led by velocities."""

    RENAMED: ClassVar[Mapping[str, str]] = {"most_correction": "max_correction"}

    namespace: str = text()
    joints: tuple[str, ...] = text()
    period: float = number(0.005, 0.1, "s")
    acceleration: Arm = number(0.1, 100.0, "rad/s^2")
    lag: float = number(0.0, 0.2, "s")
    gain: float = number(0.1, 10.0, "1/s")
    correction_speed: float = number(1e-4, 0.2, "rad/s")
    max_correction: float = number(1e-3, 0.2, "rad")
    following_error: float = number(1e-3, 0.2, "rad")
    end_tolerance: float = number(1e-4, 0.05, "rad")
    settle_time: float = number(0.05, 5.0, "s")
    feedback_rate: float = number(10.0, 1000.0, "Hz")
    feedback_age: float = number(0.01, 0.5, "s")
    rest_speed: float = number(1e-4, 0.1, "rad/s")
    reports_state: bool = flag()
    state_age: float = number(0.05, 5.0, "s")
    reports_limits: bool = flag()

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        _require_namespace(self.namespace)
        names = list(self.joints)
        allowed = f"{ARM_COUNT} names that differ, from the base on"
        require(len(names) == len(set(names)) == ARM_COUNT, "joints", names, allowed)
        allowed = f"above 1 / feedback_rate, {1.0 / self.feedback_rate:g} s: it comes as seldom"
        is_patient = self.feedback_age > 1.0 / self.feedback_rate
        require(is_patient, "feedback_age", self.feedback_age, allowed)
        allowed = f"up to following_error, {self.following_error:g} rad"
        is_less = self.end_tolerance <= self.following_error
        require(is_less, "end_tolerance", self.end_tolerance, allowed)


@dataclass(frozen=True, kw_only=True)
class ToolConfig:
    """OpenRST's node, and how its three joints are led by positions."""

    namespace: str = text()
    joints: tuple[str, ...] = text()
    signs: Triple = number(-1.0, 1.0, "")
    lower: Triple = number(-1.65, 0.0, "rad")
    upper: Triple = number(0.0, 1.65, "rad")
    period: float = number(0.002, 0.1, "s")
    feedback_age: float = number(0.005, 0.5, "s")
    following_error: float = number(0.01, 0.5, "rad")
    following_time: float = number(0.05, 5.0, "s")
    homing_limit: float = number(1.0, 600.0, "s")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        _require_namespace(self.namespace)
        names = list(self.joints)
        allowed = f"{TOOL_COUNT} names that differ: pitch, left jaw, right jaw"
        require(len(names) == len(set(names)) == TOOL_COUNT, "joints", names, allowed)
        require(all(abs(s) == 1.0 for s in self.signs), "signs", list(self.signs), "1 or -1 each")


@dataclass(frozen=True, kw_only=True)
class GripConfig:
    """How tissue between the jaws shows, and how hard it may be squeezed."""

    source: str = choice("jaws", "topic")
    closed: float = number(0.0, 0.5, "rad")
    contact: float = number(0.005, 0.5, "rad")
    contact_time: float = number(0.0, 2.0, "s")
    lost_time: float = number(0.0, 2.0, "s")
    over_close: float = number(0.01, 1.0, "rad")


@dataclass(frozen=True, kw_only=True)
class TensionSourceConfig:
    """Where the tension comes from."""

    source: str = choice("topic", "none")
    age: float = number(0.005, 1.0, "s")


@dataclass(frozen=True, kw_only=True)
class GuardConfig:
    """The process that brakes and stops the arm when the bridge has died."""

    is_required: bool = flag()
    silence: float = number(0.03, 1.0, "s")
    repeat: float = number(0.01, 1.0, "s")
    insist: float = number(0.1, 60.0, "s")
    bridge: tuple[str, ...] = text()

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require_names("bridge", self.bridge)
        allowed = f"from repeat on, {self.repeat:g} s"
        require(self.insist >= self.repeat, "insist", self.insist, allowed)
        allowed = f"from two beats of {BEAT_PERIOD:g} s on"
        require(self.silence >= 2.0 * BEAT_PERIOD, "silence", self.silence, allowed)

    @property
    def longest_gap(self) -> float:
        """How long the bridge may not run in motion [s]; the guard counts from its last beat."""
        return self.silence - BEAT_PERIOD


@dataclass(frozen=True, kw_only=True)
class BridgeConfig:
    """kinova_bridge.yaml."""

    rate: float = number(50.0, 1000.0, "Hz")
    arm: ArmConfig
    tool: ToolConfig
    grip: GripConfig
    tension: TensionSourceConfig
    guard: GuardConfig
    believed: BridgeBelievedConfig
    servo: ServoConfig

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        allowed = f"at least two in arm.period, {self.arm.period:g} s"
        require(self.rate * self.arm.period >= 2.0, "rate", self.rate, allowed)
        rounds = self.guard.longest_gap * self.rate
        allowed = f"from two rounds of rate {self.rate:g} Hz and {BEAT_PERIOD:g} s on"
        require(rounds >= 2.0, "guard.silence", self.guard.silence, allowed)
        _require_driver_keeps("servo.brake_deceleration", self.servo.brake_deceleration, self.arm)


@dataclass(frozen=True, kw_only=True)
class KinovaConfig:
    """All that the bridge reads: the form of its node's private parameters."""

    limits: LimitsConfig
    scene: SceneConfig  # whose home says in which turn each joint of the arm is
    bridge: BridgeConfig
    torques: TorqueTensionConfig  # whose errors bound the torques of an arm at rest

    @property
    def first_turns(self) -> tuple[float, ...]:
        """Home of each arm joint that turns for ever [rad]; NaN for the others. Shape (7,)."""
        limits = zip(self.limits.arm_lower, self.limits.arm_upper, self.scene.home, strict=False)
        return tuple(home if high - low > math.tau else math.nan for low, high, home in limits)


def require_drivable(config: KinovaConfig) -> None:
    """Check that arm and tool are led by the bridge wherever, and as fast as, they are planned.

    Raises:
        typed_config.ConfigError: They are not; names the joint's value and what is allowed.
    """
    plans = config.limits.active.arm_acceleration
    _require_driver_keeps("limits.active.arm_acceleration", plans, config.bridge.arm)
    led, limits = bridge_limits(config), config.limits
    planned_to = (limits.pitch, limits.finger, limits.finger)
    for joint, planned in enumerate(planned_to, ARM_COUNT):
        reach = min(-led.lower[joint], led.upper[joint])
        allowed = f"up to {reach:g} rad, which tool.lower and tool.upper leave {led.names[joint]}"
        require(planned <= reach, "limits.pitch, limits.finger", planned, allowed)


def _require_namespace(name: str) -> None:
    """Names of believed nodes are made of it: "//my_gen3/*" would fit none."""
    bare = name.strip("/")
    require(name == bare, "namespace", name, f"{bare or 'a name'}, without / at its ends")


def _require_driver_keeps(key: str, planned: Sequence[float], arm: ArmConfig) -> None:
    for joint, (value, most) in enumerate(zip(planned, arm.acceleration, strict=False), 1):
        allowed = f"up to arm.acceleration of joint_{joint}, {most:g} rad/s^2"
        require(value <= most, key, value, allowed)


def load_kinova_config(folder: Path = CONFIG_FOLDER) -> KinovaConfig:
    """Read what the bridge needs from the YAML files of a folder.

    Raises:
        typed_config.ConfigError: A key is unknown, missing or out of range; names it and its file.
    """
    limits, bridge = folder / "limits.yaml", folder / "kinova_bridge.yaml"
    scene = folder / "scene.yaml"
    return KinovaConfig(
        limits=load_file(LimitsConfig, limits),
        scene=load_file(SceneConfig, scene),
        bridge=load_file(BridgeConfig, bridge),
        torques=load_torque_tension(folder / TORQUE_TENSION_FILE.name),
    )


def bridge_limits(config: KinovaConfig) -> ServoLimits:
    """Limits of the ten joints of the active layer; the tool's by its own settings, too.

    No set-points change an arm joint's speed faster than its driver does.
    """
    limits, tool = config.limits, config.bridge.tool
    layer = limits.active
    span = np.array([limits.pitch, limits.finger, limits.finger])
    signs = np.array(tool.signs)
    ends = np.array([signs * tool.lower, signs * tool.upper])
    lower, upper = np.maximum(-span, ends.min(axis=0)), np.minimum(span, ends.max(axis=0))
    return ServoLimits(
        names=JOINTS,
        lower=np.concatenate([limits.arm_lower, lower]),
        upper=np.concatenate([limits.arm_upper, upper]),
        speed=np.array([*layer.arm_velocity, *[layer.tool_velocity] * 3]),
        acceleration=np.array([*config.bridge.arm.acceleration, *[np.inf] * TOOL_COUNT]),
    )
