# SPDX-License-Identifier: BSD-3-Clause
"""All effects together: where the joints truly go along a course, and what is read of them.

Left out, since no value is known: gears that swing, friction that depends on load and temperature,
a base that gives way, bending of links and shaft, cogging.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from rst_control.config.plant import PlantConfig
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.kinematics.inverse_dynamics import InverseDynamics
from rst_control.simulation.plant.body_wall import BodyWall
from rst_control.simulation.plant.drifting_sensor import DriftingSensor
from rst_control.simulation.plant.drives import Drives
from rst_control.simulation.plant.encoders import Encoders
from rst_control.simulation.plant.gears import Gears
from rst_control.simulation.plant.loads import add_load
from rst_control.simulation.plant.tool_play import ToolPlay
from rst_control.types import ARM_COUNT, PLAN_COUNT, Vector

GRAVITY_PERIOD: Final = 10  # steps between two evaluations of gravity, which changes slowly


@dataclass(frozen=True, eq=False)
class PlantInput:
    """What acts in one step."""

    course: Vector  # (10,), [rad] where the joints should be at its end
    speed: Vector  # (10,), [rad/s] of the course
    tip: Vector  # (3,), base frame, [m] where the force pushes
    force: Vector  # (3,), base frame, [N] of tissue and load on the jaws


class LabPlant:
    """An arm and a tool as in a laboratory.

    Args:
        config: All effects.
        dynamics: Torques of gravity.
        trocar: Between two breaths, base frame, [m]. Shape (3,).
        start: Joints [rad]. Shape (10,).
        step: Time of one `advance` [s].
    """

    def __init__(
        self,
        config: PlantConfig,
        dynamics: InverseDynamics,
        trocar: Vector,
        start: Vector,
        step: float,
    ) -> None:
        random = np.random.default_rng(config.seed)
        q, self._opening = planning_joints(start)
        self._dynamics, self._chain = dynamics, dynamics.model.chain
        self._shaft_length, self._step = dynamics.model.shaft_length, step
        self._gravity = dynamics(q)
        self.body_wall = BodyWall(config.body_wall, trocar)
        self.drives = Drives(config.drives, q[:ARM_COUNT], step)
        self.gears = Gears(config.gears, self._gravity, step)
        self.play = ToolPlay(config.tool_play, q[ARM_COUNT:], step)
        self.encoders = Encoders(config.encoders, start, step, random)
        self.torque_sensors = DriftingSensor(config.torque_sensors, step, random)
        self.force_sensor = DriftingSensor(config.force_sensor, step, random)
        self._frames = np.empty((12, 3, 4))
        self._count, self._q, self._motors = 0, np.array(q), np.array(q)
        self.wall_force = np.zeros(3)  # [N] of the body wall on the shaft, base frame
        self.wall_torques = np.zeros(ARM_COUNT)  # [N m] that hold the arm's joints against it
        forward.forward(self._chain, self._q, self._frames)

    @property
    def time(self) -> float:
        """Since the start, a breath's end [s]."""
        return self._count * self._step

    @property
    def trocar(self) -> Vector:
        """Where the trocar is now, base frame, [m]. Shape (3,)."""
        return self.body_wall.trocar(self.time)

    def advance(self, now: PlantInput) -> Vector:
        """Move on by one step; returns where the joints truly are then [rad], shape (10,)."""
        self._count += 1
        course, opening = planning_joints(now.course)
        speed, _ = planning_joints(now.speed)
        load, on_tool = self._loads(now)
        self.drives.advance(course[:ARM_COUNT], speed[:ARM_COUNT], load)
        arm = self.drives.position + self.gears.advance(load)
        tool = self.play.advance(course[ARM_COUNT:], on_tool)
        self._q, self._opening = np.concatenate([arm, tool]), opening
        forward.forward(self._chain, self._q, self._frames)
        self._motors = np.concatenate([self.drives.position, course[ARM_COUNT:]])
        return robot_joints(self._q, opening)

    def read(self) -> tuple[Vector, Vector]:
        """Positions [rad] and velocities [rad/s] as encoders at the motors read them; (10,)."""
        return self.encoders.read(robot_joints(self._motors, self._opening))

    def _loads(self, now: PlantInput) -> tuple[Vector, Vector]:
        """Torques that hold the arm's joints (7,), and those of the load on pitch and yaw (2,)."""
        if self._count % GRAVITY_PERIOD == 0:
            self._gravity = self._dynamics(self._q)
        pushed = np.zeros(PLAN_COUNT)
        add_load(self._frames, PLAN_COUNT, now.tip, now.force, pushed)
        shaft = self._frames[forward.SHAFT]
        end = shaft[:, 3] + self._shaft_length * shaft[:, 2]
        on_jaws = pushed[:ARM_COUNT].copy()
        self.wall_force, point = self.body_wall.force(self.time, shaft[:, 3], end)
        if self.wall_force.any():
            add_load(self._frames, ARM_COUNT, point, self.wall_force, pushed)
        self.wall_torques = on_jaws - pushed[:ARM_COUNT]
        return self._gravity - pushed[:ARM_COUNT], pushed[ARM_COUNT:]
