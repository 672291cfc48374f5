# SPDX-License-Identifier: BSD-3-Clause
"""plant.yaml: what a real arm, tool, sensors and trocar have, and the ideal simulation has not."""

from __future__ import annotations

from dataclasses import dataclass

from rst_control.types import Arm, Point
from typed_config import integer, number, require, require_way

Ten = tuple[float, float, float, float, float, float, float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class DrivesConfig:
    """Motors of the arm with their gears' friction, and the servo that the arm has in itself."""

    inertia: Arm = number(0.001, 10.0, "kg m^2")
    bandwidth: Arm = number(1.0, 500.0, "rad/s")
    integral: Arm = number(0.0, 1.0, "")
    static_friction: Arm = number(0.0, 50.0, "N m")
    sliding_friction: Arm = number(0.0, 50.0, "N m")
    stribeck_speed: float = number(1e-4, 0.5, "rad/s")
    viscous_friction: Arm = number(0.0, 100.0, "N m s/rad")
    load_known: float = number(0.0, 1.0, "")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        pairs = zip(self.sliding_friction, self.static_friction, strict=True)
        sliding, static = list(self.sliding_friction), list(self.static_friction)
        allowed = f"up to static_friction, {static}"
        require(all(low <= high for low, high in pairs), "sliding_friction", sliding, allowed)


@dataclass(frozen=True, kw_only=True)
class GearsConfig:
    """Gears that twist under their load."""

    stiffness: Arm = number(1000.0, 1e6, "N m/rad")
    settle_time: float = number(0.001, 1.0, "s")


@dataclass(frozen=True, kw_only=True)
class EncodersConfig:
    """How positions and velocities are measured; of arm, pitch and jaws."""

    step: Ten = number(0.0, 0.01, "rad")
    noise: Ten = number(0.0, 5e-4, "rad")
    velocity_time: float = number(0.001, 0.5, "s")


@dataclass(frozen=True, kw_only=True)
class TorqueErrorConfig:
    """Noise of a torque as read, and a drift that wanders within a standard deviation."""

    noise: Arm = number(0.0, 10.0, "N m")
    drift: Arm = number(0.0, 10.0, "N m")
    drift_time: float = number(0.1, 1e4, "s")


@dataclass(frozen=True, kw_only=True)
class ForceErrorConfig:
    """The same of a force."""

    noise: Point = number(0.0, 0.2, "N")
    drift: Point = number(0.0, 0.2, "N")
    drift_time: float = number(0.1, 1e4, "s")


@dataclass(frozen=True, kw_only=True)
class LatenessConfig:
    """How late messages come: a delay, and up to a jitter more."""

    command_delay: float = number(0.0, 0.1, "s")
    command_jitter: float = number(0.0, 0.1, "s")
    feedback_delay: float = number(0.0, 0.1, "s")
    feedback_jitter: float = number(0.0, 0.1, "s")


@dataclass(frozen=True, kw_only=True)
class BodyWallConfig:
    """A trocar that moves with the breath, and gives way to the shaft."""

    way: Point = number(-1.0, 1.0, "")
    stroke: float = number(0.0, 0.03, "m")
    rate: float = number(0.01, 2.0, "Hz")
    stiffness: float = number(1.0, 1e5, "N/m")
    slack: float = number(0.0, 0.01, "m")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require_way("way", self.way)


@dataclass(frozen=True, kw_only=True)
class ToolPlayConfig:
    """Play between OpenRST's motors and its wrist."""

    width: float = number(0.0, 0.5, "rad")
    torque: float = number(0.0, 1.0, "N m")
    speed: float = number(0.01, 100.0, "rad/s")


@dataclass(frozen=True, kw_only=True)
class PlantConfig:
    """plant.yaml."""

    seed: int = integer(0, 2**31)
    drives: DrivesConfig
    gears: GearsConfig
    encoders: EncodersConfig
    torque_sensors: TorqueErrorConfig
    force_sensor: ForceErrorConfig
    lateness: LatenessConfig
    body_wall: BodyWallConfig
    tool_play: ToolPlayConfig
