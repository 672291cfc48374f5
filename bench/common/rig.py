# SPDX-License-Identifier: BSD-3-Clause
"""Controller and simulated robot in one process and in lock-step: no ROS, no real time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np

from bench.common.ideal_robot import LightRobot
from bench.common.lockstep import START, Array, LockStep, do_nothing
from bench.common.quiet import quiet
from rst_control.admission.command_queue import CommandQueue
from rst_control.assembly import make_executor
from rst_control.commands.request import Plan
from rst_control.commands.table import COMMANDS
from rst_control.config import MotionConfig, SimulationConfig, TissueConfig
from rst_control.errors import Infeasible
from rst_control.execution.orders import Order
from rst_control.kinematics.configuration import planning_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.kinematics.rotations import turned
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.planning.planner import along
from rst_control.registration.trocar_context import ActiveTrocarContext, TrocarContext
from rst_control.robot.backend import RobotBackend
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.tissue.grasp_candidates import grasp_candidates
from rst_control.trajectory.path import Path


class Rig(LockStep):
    """Time goes on only by `tick`; a context manager.

    Args:
        motion: Settings of the controller.
        simulation: Settings of the simulated robot; its scene and limits are taken from `motion`.
        is_light: A robot without inertia instead of PyBullet's.
    """

    def __init__(
        self, motion: MotionConfig, simulation: SimulationConfig, is_light: bool = False
    ) -> None:
        model = load_robot()
        self.config, self.period = motion, 1.0 / motion.controller.rate
        context = ActiveTrocarContext(TrocarContext(motion, model))
        self.planner = context.current.planner
        settings = replace(simulation, scene=motion.scene, limits=motion.limits)
        kind = LightRobot if is_light else PybulletRobot
        with quiet():
            self.robot: LightRobot | PybulletRobot = kind(settings, start=START)
        self.link: RobotBackend = self.robot  # as the controller reaches it
        self.executor = make_executor(motion, context, self.robot.clear_fault)
        self.queue = CommandQueue(self.executor, context.verify, lambda: self.robot.now)
        self._gauge = context.trocar_pose

    def tick(self, each: Callable[[], None] = do_nothing) -> None:
        """One period of the control loop; `each` is called after every step of the physics."""
        setpoint = self.executor.tick(self.robot.now, self.link.measured_js())
        if setpoint is not None:
            self.link.servo_jp(setpoint)
        self.robot.advance(self.robot.now + self.period, each)

    def wake(self) -> None:
        """Make the controller ready for commands."""
        self.run(0.02)
        self.give("hey robot")

    @property
    def planner_joints(self) -> Array:
        """Planning configuration that the robot is led to or held at [rad]. Shape (9,)."""
        held = self.executor.snapshot.setpoint
        return planning_joints(self.robot.target if held is None else held)[0]

    def along(self, kind: PhaseKind, path: Path, speed: float) -> Phase:
        """Phase along a path as fast as the joints can follow, up to `speed` [m/s]."""
        return along(self.planner, kind, path, speed)

    def ways(self, tries: int, seed: int, min_length: float = 0.0) -> Iterator[Path]:
        """Random paths, each from where the joints are led to or held when it is asked for.

        Args:
            tries: Poses that may be tried.
            seed: Of the poses.
            min_length: Shorter paths are left out [m].
        """
        for pose in random_poses(self.config, tries, seed):
            with suppress(Infeasible):
                path = self.planner.leg(self.planner_joints, pose)
                if path.length >= min_length:
                    yield path

    def set_off(self, path: Path) -> Phase:
        """Begin a motion along a path."""
        phase = self.along(PhaseKind.REACH, path, self.config.controller.speed.tip_speed)
        plan = Plan(COMMANDS["tense"], "moves", (phase,))
        self.executor.post(Order(plan, self.executor.snapshot.serial, self.executor.latches))
        self.tick()
        return phase

    @property
    def rcm_error(self) -> float:
        """Distance of the shaft, as it truly is, from the trocar [m]."""
        return self._gauge(self.robot.true.position).error

    @property
    def tip_error(self) -> float:
        """Distance of the tip, as it truly is, from where its course has it now [m]."""
        true = self.tip_at(self.robot.true.position)
        return float(np.linalg.norm(true - self.tip_at(self.robot.target)))

    @property
    def tip(self) -> Array:
        """Tip as it truly is, base frame, [m]. Shape (3,)."""
        return self.tip_at(self.robot.true.position)


def with_tissue(config: MotionConfig, **changes: object) -> MotionConfig:
    """The same settings with another tissue."""
    tissue: TissueConfig = replace(config.scene.tissue, **changes)  # type: ignore[arg-type]
    return replace(config, scene=replace(config.scene, tissue=tissue))


def with_layer(config: MotionConfig, layer: str) -> MotionConfig:
    """The same settings with another layer of joint limits."""
    return replace(config, limits=replace(config.limits, layer=layer))


def with_speed(config: MotionConfig, **changes: float) -> MotionConfig:
    """The same settings with other speeds of the tip."""
    speed = replace(config.controller.speed, **changes)
    return replace(config, controller=replace(config.controller, speed=speed))


def random_poses(config: MotionConfig, count: int, seed: int, spread: float = 0.4) -> Array:
    """Poses of the tool in the workspace, turned by up to `spread` [rad] from the grasp's.

    Returns:
        Poses of tool_tip in base_link. Shape (count, 4, 4).
    """
    rng = np.random.default_rng(seed)
    poses = np.tile(grasp_candidates(config.scene)[0].T_base_tip, (count, 1, 1))
    for T in poses:
        direction = rng.normal(size=3)
        away = 0.95 * config.scene.workspace_radius * rng.uniform() ** (1.0 / 3.0)
        T[:3, 3] = config.scene.workspace_centre + away * direction / np.linalg.norm(direction)
        T[:3, :3] = turned(rng.uniform(-spread, spread, 3)) @ T[:3, :3]
    return poses
