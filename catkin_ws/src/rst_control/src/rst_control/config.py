# SPDX-License-Identifier: BSD-3-Clause
"""Settings of the package: a frozen dataclass per YAML file of `config/`; no key has a default."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from rst_control.collision_config import CollisionConfig
from rst_control.recording_config import RecordingConfig
from rst_control.types import PLAN_COUNT
from typed_config import (
    ConfigError,
    choice,
    flag,
    integer,
    items,
    load_config,
    load_yaml,
    number,
    text,
)

PACKAGE = Path(__file__).resolve().parents[2]
CONFIG_FOLDER = PACKAGE / "config"
URDF_FILE = PACKAGE / "urdf" / "gen3_openrst.urdf"

T = TypeVar("T")
Arm = tuple[float, float, float, float, float, float, float]
Point = tuple[float, float, float]


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

    layer: str = text()
    layers: tuple[LimitLayer, ...] = items(1, 8)
    arm_lower: Arm = number(-6.2832, 0.0, "rad")
    arm_upper: Arm = number(0.0, 6.2832, "rad")
    position_margin: float = number(0.0, 0.5, "rad")
    pitch: float = number(0.1, 1.5708, "rad")
    finger: float = number(0.1, 1.65, "rad")
    least_manipulability: float = number(0.0, 1e-5, "(m/rad)^8")


@dataclass(frozen=True, kw_only=True)
class SolverConfig:
    """Numbers of the inverse kinematics."""

    tolerance: float = number(1e-12, 1e-4, "m")
    damping: float = number(0.0, 1.0, "")
    max_iterations: int = integer(1, 1000)
    max_step: float = number(0.01, 3.2, "rad")
    restarts: int = integer(0, 10_000)


@dataclass(frozen=True, kw_only=True)
class RegistrationConfig:
    """How the trocar may be set anew, and fitted to recorded poses of the shaft."""

    tolerance: float = number(1e-6, 1e-2, "m")
    least_poses: int = integer(3, 1000)
    least_spread: float = number(0.001, 1.0, "rad")


@dataclass(frozen=True, kw_only=True)
class RcmConfig:
    """rcm.yaml: the remote centre of motion and how it is kept."""

    planned_tolerance: float = number(1e-9, 1e-3, "m")
    measured_tolerance: float = number(1e-6, 1e-2, "m")
    insertion: tuple[float, float] = number(0.0, 0.28, "m")
    knot_spacing: float = number(1e-4, 2e-3, "m")
    rotation_radius: float = number(1e-3, 1.0, "m")
    solver: SolverConfig
    registration: RegistrationConfig

    def __post_init__(self) -> None:
        tolerance, most = self.registration.tolerance, self.measured_tolerance
        if tolerance > most:  # a trocar could be set that every motion would refuse
            words = f"up to rcm.measured_tolerance, {most}"
            raise ConfigError("rcm.registration.tolerance", tolerance, words)


@dataclass(frozen=True, kw_only=True)
class TissueConfig:
    """A sheet fixed at its rim."""

    centre: Point = number(-2.0, 2.0, "m")
    along: Point = number(-1.0, 1.0, "")
    across: Point = number(-1.0, 1.0, "")
    size: tuple[float, float] = number(0.01, 0.5, "m")
    nodes: tuple[int, int] = integer(3, 101)
    rim: tuple[str, ...] = choice("start", "end", "left", "right")
    stiffness: float = number(20.0, 1000.0, "N/m")
    reference_point: Point = number(-2.0, 2.0, "m")
    reference_pull: Point = number(-0.1, 0.1, "m")
    density: float = number(0.1, 20.0, "kg/m^2")
    damping_ratio: float = number(0.0, 5.0, "")
    bed_stiffness: float = number(0.0, 10_000.0, "N/m")
    grasp_radius: float = number(1e-4, 0.02, "m")


@dataclass(frozen=True, kw_only=True)
class TriangulationConfig:
    """What a triangulated sheet keeps."""

    grasp_error: float = number(1e-5, 0.01, "m")
    least_angle: float = number(0.0, 1.0, "rad")
    out_of_plane: float = number(1e-5, 0.02, "m")
    tension: tuple[float, float] = number(0.0, 2.4, "N")
    strain: float = number(0.01, 5.0, "")


@dataclass(frozen=True, kw_only=True)
class SceneConfig:
    """scene.yaml: where trocar, robot and tissue are; read by controller and simulator."""

    trocar: Point = number(-2.0, 2.0, "m")
    home: tuple[float, ...] = number(-6.3, 6.3, "rad")
    home_opening: float = number(0.0, 1.5, "rad")
    workspace_centre: Point = number(-2.0, 2.0, "m")
    workspace_radius: float = number(0.005, 0.3, "m")
    grasp_point: Point = number(-2.0, 2.0, "m")
    approach_axis: tuple[float, ...] = number(-1.0, 1.0, "")
    jaw_axis: tuple[float, ...] = number(-1.0, 1.0, "")
    clearance: float = number(0.001, 0.05, "m")
    pull_direction: tuple[float, ...] = number(-1.0, 1.0, "")
    max_displacement: float = number(0.001, 0.1, "m")
    outward: Point = number(-1.0, 1.0, "")
    surface_margin: float = number(0.001, 0.1, "m")
    standoff: float = number(0.005, 0.3, "m")
    tissue: TissueConfig
    triangulation: TriangulationConfig

    def __post_init__(self) -> None:
        for name in ("approach_axis", "jaw_axis", "pull_direction"):
            way = getattr(self, name)
            if len(way) not in (0, 3) or (way and not any(way)):
                raise ConfigError(f"scene.{name}", list(way), "[] or three numbers, not all 0")


@dataclass(frozen=True, kw_only=True)
class SpeedConfig:
    """Speed profile along the path."""

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

    open: float = number(0.0, 1.5, "rad")
    speed: float = number(0.01, 3.0, "rad/s")
    acceleration: float = number(0.01, 20.0, "rad/s^2")
    jerk: float = number(0.1, 1000.0, "rad/s^3")
    settle_time: float = number(0.0, 2.0, "s")


@dataclass(frozen=True, kw_only=True)
class TensionConfig:
    """Pull of the tissue on the jaws."""

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
    delay: float = number(0.0, 0.1, "s")
    settle_time: float = number(0.0, 2.0, "s")

    def __post_init__(self) -> None:
        if self.maximum >= self.limit:  # a pull to it would stop just below, and never arrive
            raise ConfigError("controller.tension.maximum", self.maximum, f"below {self.limit}")
        if not self.minimum <= self.initial <= self.maximum:
            words = f"{self.minimum} to {self.maximum}, minimum to maximum"
            raise ConfigError("controller.tension.initial", self.initial, words)


@dataclass(frozen=True, kw_only=True)
class WatchdogConfig:
    """What makes the controller brake and latch, or refuse to start."""

    joint_state_age: float = number(0.002, 1.0, "s")
    following_error: float = number(1e-4, 1.0, "rad")
    voice_heartbeat_age: float = number(0.05, 10.0, "s")
    at_rest_speed: float = number(1e-5, 0.1, "rad/s")
    phase_timeout: float = number(1.0, 600.0, "s")


@dataclass(frozen=True, kw_only=True)
class ControllerConfig:
    """controller.yaml: the control loop, its speeds, forces and watchdogs."""

    rate: float = number(50.0, 2000.0, "Hz")
    state_rate: float = number(1.0, 200.0, "Hz")
    spoken_by: str = text()
    speed: SpeedConfig
    jaws: JawsConfig
    tension: TensionConfig
    watchdogs: WatchdogConfig
    recording: RecordingConfig


@dataclass(frozen=True, kw_only=True)
class ServoConfig:
    """How the simulated robot follows set-points, and stops when they stop coming."""

    period: float = number(0.0005, 0.1, "s")
    playout_delay: float = number(0.0, 0.1, "s")
    stale_after: float = number(0.002, 1.0, "s")
    lead: float = number(0.0, 10.0, "s")
    buffer: int = integer(4, 10_000)
    start_tolerance: float = number(1e-6, 0.5, "rad")
    rest_speed: float = number(1e-6, 0.1, "rad/s")
    following_error: float = number(1e-4, 1.0, "rad")
    brake_deceleration: tuple[float, ...] = number(0.1, 100.0, "rad/s^2")


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

    physics_rate: float = number(100.0, 10_000.0, "Hz")
    publish_rate: float = number(10.0, 1000.0, "Hz")
    real_time_factor: float = number(0.0, 100.0, "")
    catch_up: float = number(0.001, 10.0, "s")
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
        if len(self.start_position) not in (0, PLAN_COUNT):
            allowed = f"a list of {PLAN_COUNT} angles [rad], or [] for the scene's home"
            raise ConfigError("start_position", list(self.start_position), allowed)
        steps = self.physics_rate / self.publish_rate
        if steps < 1.0 or not steps.is_integer():  # else it would publish at some other rate
            allowed = f"a whole multiple of publish_rate, {self.publish_rate:g} Hz"
            raise ConfigError("physics_rate", self.physics_rate, allowed)


@dataclass(frozen=True, kw_only=True)
class MotionConfig:
    """All that planning and control read: the form of the controller node's private parameters."""

    limits: LimitsConfig
    rcm: RcmConfig
    scene: SceneConfig
    controller: ControllerConfig
    collision: CollisionConfig


@dataclass(frozen=True, kw_only=True)
class SimulationConfig:
    """All that the simulator node reads."""

    limits: LimitsConfig
    scene: SceneConfig
    simulator: SimulatorConfig


def load_motion_config(folder: Path = CONFIG_FOLDER) -> MotionConfig:
    """Read what planning and control need from the YAML files of a folder.

    Raises:
        typed_config.ConfigError: A key is unknown, missing or out of range; names it and its file.
    """
    return MotionConfig(
        limits=_read(LimitsConfig, folder / "limits.yaml"),
        rcm=_read(RcmConfig, folder / "rcm.yaml"),
        scene=_read(SceneConfig, folder / "scene.yaml"),
        controller=_read(ControllerConfig, folder / "controller.yaml"),
        collision=_read(CollisionConfig, folder / "collision.yaml"),
    )


def load_simulation_config(folder: Path = CONFIG_FOLDER) -> SimulationConfig:
    """Read what the simulator needs from the YAML files of a folder.

    Raises:
        typed_config.ConfigError: A key is unknown, missing or out of range; names it and its file.
    """
    return SimulationConfig(
        limits=_read(LimitsConfig, folder / "limits.yaml"),
        scene=_read(SceneConfig, folder / "scene.yaml"),
        simulator=_read(SimulatorConfig, folder / "simulator.yaml"),
    )


def _read(kind: type[T], path: Path) -> T:
    return load_config(kind, load_yaml(path), path.name)
