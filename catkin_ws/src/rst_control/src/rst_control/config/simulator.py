# SPDX-License-Identifier: BSD-3-Clause
"""simulator.yaml: the simulated robot and how it follows set-points."""

from __future__ import annotations

from dataclasses import dataclass

from rst_control.types import JOINT_COUNT, PLAN_COUNT, Point
from typed_config import choice, flag, integer, number, require, text
from typed_config.node_names import require_names


@dataclass(frozen=True, kw_only=True)
class ServoConfig:
    """How the simulated robot follows set-points, and stops when they stop coming."""

    period: float = number(0.0005, 0.1, "s")
    playout_delay: float = number(0.0, 0.1, "s")
    stale_after: float = number(0.002, 1.0, "s")
    lead: float = number(0.0, 10.0, "s")
    buffer: int = integer(4, 10_000)
    start_tolerance: float = number(1e-6, 0.02, "rad")
    rest_speed: float = number(1e-6, 0.05, "rad/s")
    following_error: float = number(1e-4, 1.0, "rad")
    brake_deceleration: tuple[float, ...] = number(0.1, 100.0, "rad/s^2")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        allowed = f"a list of {JOINT_COUNT} numbers [rad/s^2]"
        most = list(self.brake_deceleration)
        require(len(most) == JOINT_COUNT, "brake_deceleration", most, allowed)
        allowed = f"above period, {self.period:g} s"
        require(self.stale_after > self.period, "stale_after", self.stale_after, allowed)


@dataclass(frozen=True, kw_only=True)
class CameraConfig:
    """Where a picture of the scene is taken from."""

    size: tuple[int, int] = integer(64, 4096, "pixels")
    target: Point = number(-2.0, 2.0, "m")
    distance: float = number(0.01, 5.0, "m")
    yaw: float = number(-6.3, 6.3, "rad")
    pitch: float = number(-1.6, 1.6, "rad")
    field_of_view: float = number(0.1, 2.0, "rad")
    reach: float = number(0.05, 100.0, "m")
    sky_top: Point = number(0.0, 1.0, "")
    sky_bottom: Point = number(0.0, 1.0, "")


@dataclass(frozen=True, kw_only=True)
class SimulatorConfig:
    """simulator.yaml: the simulated robot."""

    mode: str = choice("fast", "kinova_strict")
    plant: str = choice("ideal", "lab")
    physics_rate: float = number(100.0, 10_000.0, "Hz")
    publish_rate: float = number(10.0, 1000.0, "Hz")
    real_time_factor: float = number(0.0, 100.0, "")
    catch_up: float = number(0.001, 10.0, "s")
    led_by: tuple[str, ...] = text()
    gui: bool = flag()
    closed_opening: float = number(0.0, 0.5, "rad")
    held_opening: float = number(0.0, 0.5, "rad")
    tool_load: float = number(0.0, 20.0, "N")
    tool_joint_error: Point = number(-0.5, 0.5, "rad")
    start_position: tuple[float, ...] = number(-6.3, 6.3, "rad")
    servo: ServoConfig
    overview: CameraConfig
    endoscope: CameraConfig

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require_names("led_by", self.led_by)
        start = list(self.start_position)
        allowed = f"a list of {PLAN_COUNT} angles [rad], or [] for the scene's home"
        require(len(start) in (0, PLAN_COUNT), "start_position", start, allowed)
        steps = self.physics_rate / self.publish_rate  # else it would publish at some other rate
        allowed = f"a whole multiple of publish_rate, {self.publish_rate:g} Hz"
        is_whole = steps >= 1.0 and steps.is_integer()
        require(is_whole, "physics_rate", self.physics_rate, allowed)
        allowed = f"above closed_opening, {self.closed_opening:g} rad"
        is_wider = self.held_opening > self.closed_opening
        require(is_wider, "held_opening", self.held_opening, allowed)
        high, other = self.overview.size[1], list(self.endoscope.size)
        allowed = f"as high as overview.size, {high} pixels: one picture holds both"
        require(other[1] == high, "endoscope.size", other, allowed)
        allowed = f"from catch_up on, {self.catch_up:g} s"
        require(self.servo.lead >= self.catch_up, "servo.lead", self.servo.lead, allowed)
