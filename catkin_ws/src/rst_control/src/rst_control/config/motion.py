# SPDX-License-Identifier: BSD-3-Clause
"""limits.yaml, rcm.yaml and controller.yaml, and what each node reads; no key has a default."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from rst_control.config.believed import BelievedConfig
from rst_control.config.callers import CallersConfig
from rst_control.config.camera import CameraStepConfig
from rst_control.config.collision import CollisionConfig
from rst_control.config.compensation import JointCorrectionConfig, PlayCompensationConfig
from rst_control.config.plant import PlantConfig
from rst_control.config.recording import RecordingConfig
from rst_control.config.scene import SceneConfig
from rst_control.config.sensors import SensorConfig
from rst_control.config.simulator import SimulatorConfig
from rst_control.config.tracking import TrackingConfig
from rst_control.types import Arm
from typed_config import (
    choice,
    integer,
    items,
    load_file,
    number,
    package_folder,
    require,
    require_rising,
    text,
)

PACKAGE = package_folder("rst_control")
CONFIG_FOLDER = PACKAGE / "config"
URDF_FILE = PACKAGE / "urdf" / "gen3_openrst.urdf"

EMPTY = 0.15  # [rad] between jaws, beyond which they hold nothing: a grasp ends there
MIN_OPEN = 0.2  # [rad] that open jaws stand apart at least: EMPTY and a reserve
PROMPT = 0.02  # [s] from a set-point to its measurement, for corrected joints, a followed trocar
ROUNDING = 1e-9  # [-] share by which a quotient of settings may miss its value


@dataclass(frozen=True, kw_only=True)
class LimitLayer:
    """One set of joint limits; joint_7 is the last of the arm."""

    name: str = text()
    arm_velocity: Arm = number(0.01, 10.0, "rad/s")
    arm_acceleration: Arm = number(0.01, 100.0, "rad/s^2")
    tool_velocity: float = number(0.01, 10.0, "rad/s")
    tool_acceleration: float = number(0.01, 100.0, "rad/s^2")
    stopping_time: float = number(0.005, 10.0, "s")
    stopping_distance: float = number(5e-5, 0.1, "m")


@dataclass(frozen=True, kw_only=True)
class LimitsConfig:
    """limits.yaml: how far and how fast joints may move."""

    RENAMED: ClassVar[Mapping[str, str]] = {"least_manipulability": "min_manipulability"}

    layer: str = text()
    layers: tuple[LimitLayer, ...] = items(1, 8)
    arm_lower: Arm = number(-6.2832, 0.0, "rad")
    arm_upper: Arm = number(0.0, 6.2832, "rad")
    position_margin: float = number(0.0, 0.5, "rad")
    pitch: float = number(0.1, 1.5708, "rad")
    finger: float = number(0.1, 1.65, "rad")
    min_manipulability: float = number(0.0, 1e-5, "(m/rad)^8")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        names = [layer.name for layer in self.layers]
        require(len(set(names)) == len(names), "layers", names, "names that differ")
        self.named(self.layer)
        for joint, (low, high) in enumerate(zip(self.arm_lower, self.arm_upper, strict=True)):
            room = high - low - 2.0 * self.position_margin
            allowed = f"below the range of joint_{joint + 1}, {low:g} to {high:g} rad, by half"
            require(room > 0.0, "position_margin", self.position_margin, allowed)
        allowed = f"above position_margin, {self.position_margin:g} rad"
        require(self.pitch > self.position_margin, "pitch", self.pitch, allowed)

    @property
    def active(self) -> LimitLayer:
        """The layer that is chosen."""
        return self.named(self.layer)

    def named(self, name: str) -> LimitLayer:
        """The layer of a name.

        Raises:
            ConfigError: There is no such layer.
        """
        layers = {layer.name: layer for layer in self.layers}
        require(name in layers, "layer", name, f"one of {', '.join(layers)}")
        return layers[name]


@dataclass(frozen=True, kw_only=True)
class SolverConfig:
    """Numbers of the inverse kinematics."""

    tolerance: float = number(1e-12, 1e-8, "m")
    damping: float = number(0.0, 1.0, "")
    max_iterations: int = integer(1, 1000)
    max_step: float = number(0.01, 3.2, "rad")
    restarts: int = integer(0, 10_000)


@dataclass(frozen=True, kw_only=True)
class RegistrationConfig:
    """How the trocar may be set again, and fitted to recorded poses of the shaft."""

    RENAMED: ClassVar[Mapping[str, str]] = {
        "least_poses": "min_poses",
        "least_spread": "min_spread",
    }

    tolerance: float = number(1e-6, 1e-2, "m")
    min_poses: int = integer(3, 1000)
    min_spread: float = number(0.001, 1.0, "rad")


@dataclass(frozen=True, kw_only=True)
class RcmConfig:
    """rcm.yaml: the remote centre of motion and how it is kept."""

    planned_tolerance: float = number(1e-9, 1e-4, "m")
    measured_tolerance: float = number(1e-6, 1e-2, "m")
    insertion: tuple[float, float] = number(0.0, 0.6, "m")
    knot_spacing: float = number(1e-4, 2e-3, "m")
    rotation_radius: float = number(1e-3, 1.0, "m")
    max_joint_way: float = number(0.5, 6.2832, "rad")
    elbow_allowance: float = number(0.0, 1.0, "m")
    elbow_ratio: float = number(0.0, 100.0, "")
    solver: SolverConfig
    registration: RegistrationConfig

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require_rising("insertion", self.insertion)
        planned, most = self.planned_tolerance, self.measured_tolerance
        allowed = f"up to measured_tolerance, {most}"
        require(planned <= most, "planned_tolerance", planned, allowed)
        tolerance = self.registration.tolerance  # else a trocar could be set that motion refuses
        require(tolerance <= most, "registration.tolerance", tolerance, allowed)
        allowed = f"up to planned_tolerance, {planned}"
        solved = self.solver.tolerance
        require(solved <= planned, "solver.tolerance", solved, allowed)


@dataclass(frozen=True, kw_only=True)
class SpeedConfig:
    """Speed profile along the path."""

    scale: float = number(0.001, 1.0, "")
    tip_speed: float = number(1e-4, 0.1, "m/s")
    pull_speed: float = number(1e-4, 0.1, "m/s")
    insertion: float = number(1e-4, 0.1, "m/s")
    approach: float = number(1e-4, 0.1, "m/s")
    acceleration: float = number(0.01, 10.0, "m/s^2")
    jerk: float = number(0.1, 1000.0, "m/s^3")
    braking_jerk: float = number(0.1, 10_000.0, "m/s^3")


@dataclass(frozen=True, kw_only=True)
class JawsConfig:
    """Opening and closing of the jaws."""

    open: float = number(MIN_OPEN, 1.5, "rad")
    speed: float = number(0.01, 3.0, "rad/s")
    acceleration: float = number(0.01, 20.0, "rad/s^2")
    jerk: float = number(0.1, 1000.0, "rad/s^3")
    braking: float = number(0.01, 20.0, "rad/s^2")
    braking_jerk: float = number(0.1, 5000.0, "rad/s^3")
    settle_time: float = number(0.0, 2.0, "s")


@dataclass(frozen=True, kw_only=True)
class TensionConfig:
    """Pull of the tissue on the jaws."""

    source: str = choice("sensor", "joint_torque", "none")
    gain: str = choice("checked", "unchecked")
    blind_stiffness: float = number(20.0, 4000.0, "N/m")
    initial: float = number(0.05, 2.4, "N")
    minimum: float = number(0.0, 1.0, "N")
    maximum: float = number(0.1, 2.4, "N")
    limit: float = number(0.1, 2.4, "N")
    tolerance: float = number(0.001, 0.2, "N")
    step_by: str = choice("tension", "distance")
    step_tension: float = number(0.01, 1.0, "N")
    step_distance: float = number(1e-4, 0.02, "m")
    bandwidth: float = number(0.5, 100.0, "1/s")
    stiffness_range: tuple[float, float] = number(1.0, 20_000.0, "N/m")
    noise: float = number(1e-4, 0.1, "N")
    delay: float = number(0.0, 0.3, "s")
    settle_time: float = number(0.0, 2.0, "s")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        allowed = f"below {self.limit}"  # a pull to it would stop just below, and never arrive
        require(self.maximum < self.limit, "maximum", self.maximum, allowed)
        allowed = f"{self.minimum} to {self.maximum}, minimum to maximum"
        is_between = self.minimum <= self.initial <= self.maximum
        require(is_between, "initial", self.initial, allowed)
        require_rising("stiffness_range", self.stiffness_range)


@dataclass(frozen=True, kw_only=True)
class WatchdogConfig:
    """What makes the controller brake and latch, or refuse to start."""

    joint_state_age: float = number(0.002, 1.0, "s")
    following_error: float = number(1e-4, 1.0, "rad")
    voice_heartbeat_age: float = number(0.05, 10.0, "s")
    dead_man_age: float = number(0.15, 10.0, "s")
    at_rest_speed: float = number(1e-5, 0.1, "rad/s")
    phase_timeout: float = number(1.0, 600.0, "s")
    sensors: SensorConfig


@dataclass(frozen=True, kw_only=True)
class ControllerConfig:
    """controller.yaml: the control loop, its speeds, forces and watchdogs."""

    RENAMED: ClassVar[Mapping[str, str]] = {"look": "camera"}

    rate: float = number(50.0, 2000.0, "Hz")
    state_rate: float = number(1.0, 200.0, "Hz")
    spoken_by: str = text()
    first_motion: str = choice("free", "confirmed")
    homing: str = choice("outside", "anywhere")
    speed: SpeedConfig
    jaws: JawsConfig
    tension: TensionConfig
    camera: CameraStepConfig
    watchdogs: WatchdogConfig
    recording: RecordingConfig
    callers: CallersConfig
    believed: BelievedConfig
    tracking: TrackingConfig
    tool_play: PlayCompensationConfig
    joint_correction: JointCorrectionConfig

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        allowed = f"up to rate, {self.rate:g} Hz"
        require(self.state_rate <= self.rate, "state_rate", self.state_rate, allowed)
        tension, sensors = self.tension, self.watchdogs.sensors
        most = tension.maximum / tension.blind_stiffness  # dead sensor, stiffest tissue
        allowed = f"up to {most:.4f}, tension.maximum over tension.blind_stiffness"
        is_bound = sensors.slack_way <= most
        require(is_bound, "watchdogs.sensors.slack_way", sensors.slack_way, allowed)
        most = tension.limit - tension.maximum
        allowed = f"up to {most:.2f}, tension.limit less tension.maximum"
        deficit = sensors.tension_deficit
        require(deficit <= most, "watchdogs.sensors.tension_deficit", deficit, allowed)
        gain, is_prompt = self.joint_correction.gain, tension.delay <= PROMPT
        allowed = f"0 where tension.delay is above {PROMPT} s: the arm would swing"
        require(gain == 0.0 or is_prompt, "joint_correction.gain", gain, allowed)
        motion = self.tracking.trocar.motion  # led by velocities, the shaft left the trocar
        allowed = f"fixed where tension.delay is above {PROMPT} s"
        require(motion == "fixed" or is_prompt, "tracking.trocar.motion", motion, allowed)


@dataclass(frozen=True, kw_only=True)
class MotionConfig:
    """All that planning and control read: the form of the controller node's private parameters."""

    limits: LimitsConfig
    rcm: RcmConfig
    scene: SceneConfig
    controller: ControllerConfig
    collision: CollisionConfig

    def __post_init__(self) -> None:
        """Check what no file shows alone."""
        limits, opening = self.limits, self.controller.jaws.open
        least = 0.5 * opening + limits.position_margin  # else no yaw would be left
        allowed = f"above {least:g} rad, half of controller.jaws.open ({opening:g} rad)"
        allowed += f" and limits.position_margin ({limits.position_margin:g} rad)"
        require(limits.finger > least, "limits.finger", limits.finger, allowed)
        self._require_jaws_within_limits()

    def _require_jaws_within_limits(self) -> None:
        """Check the opening's speed and accelerations, of which each jaw takes half."""
        layer, jaws, scale = self.limits.active, self.controller.jaws, self.controller.speed.scale
        most = 2.0 * layer.tool_velocity / scale
        allowed = f"up to {most:g} rad/s, twice tool_velocity of limits.layers"
        allowed += f" ({layer.name}: {layer.tool_velocity:g} rad/s) over controller.speed.scale"
        is_slow = jaws.speed <= most * (1.0 + ROUNDING)
        require(is_slow, "controller.jaws.speed", jaws.speed, f"{allowed} ({scale:g})")
        most = 2.0 * layer.tool_acceleration
        allowed = f"up to {most:g} rad/s^2, twice tool_acceleration of limits.layers"
        allowed += f" ({layer.name}: {layer.tool_acceleration:g} rad/s^2)"
        for key in ("acceleration", "braking"):
            value = getattr(jaws, key)
            require(value <= most, f"controller.jaws.{key}", value, allowed)


@dataclass(frozen=True, kw_only=True)
class SimulationConfig:
    """All that the simulator node reads."""

    limits: LimitsConfig
    scene: SceneConfig
    simulator: SimulatorConfig
    plant: PlantConfig


def load_motion_config(folder: Path = CONFIG_FOLDER) -> MotionConfig:
    """Read what planning and control need from the YAML files of a folder.

    Raises:
        typed_config.ConfigError: A key is unknown, missing or out of range; names it and its file.
    """
    return MotionConfig(
        limits=load_file(LimitsConfig, folder / "limits.yaml"),
        rcm=load_file(RcmConfig, folder / "rcm.yaml"),
        scene=load_file(SceneConfig, folder / "scene.yaml"),
        controller=load_file(ControllerConfig, folder / "controller.yaml"),
        collision=load_file(CollisionConfig, folder / "collision.yaml"),
    )


def load_simulation_config(folder: Path = CONFIG_FOLDER) -> SimulationConfig:
    """Read what the simulator needs from the YAML files of a folder.

    Raises:
        typed_config.ConfigError: A key is unknown, missing or out of range; names it and its file.
    """
    return SimulationConfig(
        limits=load_file(LimitsConfig, folder / "limits.yaml"),
        scene=load_file(SceneConfig, folder / "scene.yaml"),
        simulator=load_file(SimulatorConfig, folder / "simulator.yaml"),
        plant=load_file(PlantConfig, folder / "plant.yaml"),
    )
