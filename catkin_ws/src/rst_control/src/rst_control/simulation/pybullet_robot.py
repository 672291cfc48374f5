# SPDX-License-Identifier: BSD-3-Clause
"""The simulated robot: a servo that follows set-points, PyBullet's physics, tissue in the jaws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from rst_control.config import URDF_FILE, LimitsConfig, SimulationConfig
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.inverse_dynamics import InverseDynamics
from rst_control.kinematics.joint_limits import require_lacking_at_zero
from rst_control.kinematics.robot_model import load_robot
from rst_control.robot import joint_kernels
from rst_control.robot.backend import RobotBackend
from rst_control.robot.setpoint_servo import Servo, ServoLimits, ServoState, warm_up
from rst_control.simulation.physics import JointReading, RobotPhysics
from rst_control.simulation.plant import LabPlant, PlantInput
from rst_control.simulation.tissue import Jaws, SimulatedTissue
from rst_control.types import ARM_COUNT, JOINTS, Measurement, Setpoint, Vector, unit_vector
from typed_config import ConfigError

IDEAL = "ideal"  # simulator.plant


class PybulletRobot(RobotBackend):
    """The simulated robot; its time is moved on by `step`. A context manager.

    Args:
        config: Limits, scene and simulator settings.
        urdf: Model of the robot.
        start: Time of the first state [s]; set-points are stamped on the same clock.

    Raises:
        ConfigError: The start position is beyond the limits of a joint, or turns one that the arm
            lacks.
        FileNotFoundError: There is no such model.
    """

    def __init__(
        self, config: SimulationConfig, urdf: Path = URDF_FILE, start: float = 0.0
    ) -> None:
        simulator, scene = config.simulator, config.scene
        self.time_step = 1.0 / simulator.physics_rate
        begin = start_joints(config)
        self._start, self._steps = start, 0
        self._error = np.array([0.0] * 7 + list(simulator.tool_joint_error))
        self._has_error = bool(self._error.any())
        limits = servo_limits(config.limits)
        require_within(limits, begin)
        require_lacking_at_zero("start", begin, load_robot(urdf))
        self._physics = RobotPhysics(urdf, begin + self._error, self.time_step, scene.gravity)
        warm_up(simulator.servo, limits)
        self._servo = Servo(simulator.servo, limits, begin)
        self._following_error = simulator.servo.following_error
        self.tissue = SimulatedTissue(scene.tissue, self.time_step)
        self._plant = self._make_plant(config, urdf, begin)
        self._led = begin + self._error  # [rad] where the joints were led last
        self._jaws = Jaws(self.tissue, simulator.closed_opening, simulator.held_opening)
        self._load = simulator.tool_load * unit_vector(self._physics.gravity)
        self._target, self._true = begin, self._physics.read()
        self._reading = self._as_reported(self._true)
        self._force = self._felt = np.zeros(3)
        self._check_following()

    @property
    def now(self) -> float:
        """Time of the present state [s]."""
        return self._start + self._steps * self.time_step

    @property
    def tip(self) -> Vector:
        """Point between the tips of the jaws, base frame, [m]. Shape (3,)."""
        return self._physics.grasp_centre

    @property
    def target(self) -> Vector:
        """Where the joints should be now [rad]. Shape (10,)."""
        return self._target

    @property
    def reading(self) -> JointReading:
        """Joints as they are measured now."""
        return self._reading

    @property
    def true(self) -> JointReading:
        """Joints as they are now, whatever is measured."""
        return self._true

    @property
    def force(self) -> Vector:
        """Force of the tissue on the jaws as it is measured, base frame, [N]. Shape (3,)."""
        return self._felt

    @property
    def true_force(self) -> Vector:
        """The same as it is, whatever is measured."""
        return self._force

    @property
    def plant(self) -> LabPlant | None:
        """What is not ideal; None: all is."""
        return self._plant

    @property
    def fault(self) -> str:
        """Why the robot takes no set-points; empty when it is healthy."""
        return self._servo.fault

    @property
    def servo_state(self) -> ServoState:
        """Whether it holds, follows or brakes."""
        return self._servo.state

    @property
    def rest(self) -> Vector | None:
        """Where it holds the joints [rad], shape (10,); None while they are led, or brake."""
        return self._servo.rest

    @property
    def newest_setpoint(self) -> float:
        """Stamp of the newest set-point in play [s]; minus infinity while there is none."""
        return self._servo.newest_stamp

    def shaft(self) -> tuple[Vector, Vector]:
        """Both ends of the tool's shaft, base frame, [m]. Shapes (3,)."""
        return self._physics.shaft()

    def measured_js(self) -> Measurement:
        """Present joint states and the force on the jaws."""
        return Measurement(
            position=self._reading.position,
            velocity=self._reading.velocity,
            effort=self._reading.effort,
            stamp=self.now,
            force=self._felt,
            gripped=self.tissue.is_held,
            fault=self._servo.fault,
            sent_to=self._servo.rest,
        )

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Take one set-point of a stream; what no joint may follow raises a fault."""
        self._servo.accept(setpoint, self.now)

    def hold(self) -> None:
        """Slow down and stay."""
        self._servo.hold(self.now)

    def fail(self, reason: str) -> None:
        """Latch a fault found elsewhere, slow down and stay."""
        self._servo.fail(reason, self.now)

    def clear_fault(self) -> None:
        """Take set-points again, if the joints are at rest."""
        self._servo.clear_fault()

    def step(self) -> None:
        """Move on by one step of the physics."""
        self._steps += 1
        target, speed = self._servo.course(self.now)
        led = self._where_led(target, speed)
        self._physics.drive(self._led, (led - self._led) / self.time_step)
        self._physics.push_jaws(self._force + self._load)
        true, tip = self._physics.step(), self._physics.grasp_centre
        self._true, self._target, self._led = true, target, led
        self._reading = self._as_reported(true)
        opening = true.position.item(8) + true.position.item(9)
        self._jaws.follow(opening, tip)
        self._force = self.tissue.advance(tip)
        plant = self._plant
        self._felt = self._force if plant is None else plant.force_sensor.read(self._force)
        self._check_following()

    def advance(self, until: float, each: Callable[[], None] = lambda: None) -> None:
        """Step until a time.

        Args:
            until: Time to reach [s].
            each: Called after every step.
        """
        while self.now < until - 0.5 * self.time_step:
            self.step()
            each()

    def push_load(self, force: Vector) -> None:
        """Push at the tool tip from now on, instead of the configured load; [N], base frame."""
        self._load = np.array(force, dtype=float)

    def skip(self, duration: float) -> None:
        """Let time pass in which nothing happens, as after the computer was too slow.

        Raises:
            RuntimeError: The joints are not at rest.
        """
        if self._servo.state is not ServoState.HOLDING:
            raise RuntimeError("time cannot be skipped while the joints move")
        self._start += duration

    def close(self) -> None:
        """Leave the physics; calling it twice does no harm."""
        self._physics.close()

    def __enter__(self) -> PybulletRobot:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _make_plant(self, config: SimulationConfig, urdf: Path, begin: Vector) -> LabPlant | None:
        if config.simulator.plant == IDEAL:
            return None
        dynamics = InverseDynamics(urdf.read_text(encoding="utf-8"), gravity=self._physics.gravity)
        trocar = np.array(config.scene.trocar)
        return LabPlant(config.plant, dynamics, trocar, begin, self.time_step)

    def _where_led(self, target: Vector, speed: Vector) -> Vector:
        """Where the joints truly go on their way to a target [rad]. Shape (10,)."""
        plant = self._plant
        if plant is not None:
            tip, force = self._physics.grasp_centre, self._force + self._load
            target = plant.advance(PlantInput(target, speed, tip, force))
        return target + self._error if self._has_error else target

    def _as_reported(self, true: JointReading) -> JointReading:
        if self._plant is not None:
            position, velocity = self._plant.read()
            effort = np.array(true.effort)
            arm = effort[:ARM_COUNT] + self._plant.wall_torques  # PyBullet knows of no wall
            effort[:ARM_COUNT] = self._plant.torque_sensors.read(arm)
            return JointReading(position, velocity, effort)
        return replace(true, position=true.position - self._error) if self._has_error else true

    def _check_following(self) -> None:
        joint, away = joint_kernels.furthest(self._reading.position, self._target)
        if away > self._following_error:
            self.fail(
                f"{JOINTS[joint]} is {away:.4f} rad off its course, "
                f"allowed {self._following_error:.4f}"
            )


def start_joints(config: SimulationConfig) -> Vector:
    """Where the simulated robot begins: its own start position, else the scene's home.

    Returns:
        Joints [rad]. Shape (10,).
    """
    q = config.simulator.start_position or config.scene.home
    return robot_joints(np.array(q), config.scene.home_opening)


def require_within(limits: ServoLimits, begin: Vector) -> None:
    """Refuse a start that the joints cannot stand at; it would jump at the first step.

    Raises:
        ConfigError: Names the joint.
    """
    for name, value, low, high in zip(
        limits.names, begin.tolist(), limits.lower, limits.upper, strict=True
    ):
        if not low <= value <= high:
            raise ConfigError(f"start of {name}", value, f"{low:.4f} to {high:.4f} rad")


def servo_limits(config: LimitsConfig) -> ServoLimits:
    """Limits of the ten joints: positions, and speeds of the active layer."""
    layer = config.active
    tool = np.array([config.pitch, config.finger, config.finger])
    return ServoLimits(
        names=JOINTS,
        lower=np.concatenate([config.arm_lower, -tool]),
        upper=np.concatenate([config.arm_upper, tool]),
        speed=np.array([*layer.arm_velocity, *[layer.tool_velocity] * 3]),
    )
