# SPDX-License-Identifier: BSD-3-Clause
"""Controller and simulated robot in one process and in lock-step: no ROS, no real time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from bench.motion.light_robot import LightRobot
from bench.motion.quiet import quiet
from rst_control import chain
from rst_control.assembly import make_executor
from rst_control.backends.pybullet_robot import PybulletRobot
from rst_control.config import MotionConfig, SimulationConfig, TissueConfig
from rst_control.configuration import Configuration, planning_joints
from rst_control.desk import CommandDesk, Ticket
from rst_control.grasp_ways import grasp_ways, turned
from rst_control.lifecycle import IN_MOTION
from rst_control.path import Path
from rst_control.phases import along
from rst_control.robot_model import load_robot
from rst_control.site import PresentSite, Site
from rst_control.types import Phase, PhaseKind, Request

Array = NDArray[np.float64]
START = 10.0  # [s] time of the first state
AT_ONCE = ("hey robot", "stop", "terminate")


class Rig:
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
        site = PresentSite(Site(motion, model))
        self.planner = site.site.planner
        settings = replace(simulation, scene=motion.scene, limits=motion.limits)
        kind = LightRobot if is_light else PybulletRobot
        with quiet():
            self.robot: LightRobot | PybulletRobot = kind(settings, start=START)
        self.error = np.array([0.0] * 7 + list(settings.simulator.tool_joint_error))
        self.executor = make_executor(motion, site, self.robot.clear_fault)
        self.desk = CommandDesk(self.executor, site.verify, lambda: self.robot.now)
        self._gauge = site.placement

    def tick(self, each: Callable[[], None] = lambda: None) -> None:
        """One period of the control loop; `each` is called after every step of the physics."""
        setpoint = self.executor.tick(self.robot.now, self.robot.measured_js())
        if setpoint is not None:
            self.robot.servo_jp(setpoint)
        self.robot.advance(self.robot.now + self.period, each)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / self.period)):
            self.tick()

    def until(self, condition: Callable[[], bool], limit: float = 30.0) -> bool:
        """Tick until the condition holds; False where it did not within `limit` [s]."""
        for _ in range(round(limit / self.period)):
            if condition():
                return True
            self.tick()
        return False

    def give(self, words: str, tension: float = 0.0, distance: float = 0.0) -> Ticket:
        """Give a command and tick until it is answered."""
        ticket = self.desk.take(Request(words, tension, distance), "bench")
        while not ticket.reply.done():
            waiting = None if words in AT_ONCE else self.desk.next(0.0)
            if waiting is not None:
                self.desk.check(waiting)
            self.tick()
        return ticket

    def wake(self) -> None:
        """Make the controller ready for commands."""
        self.run(0.02)
        self.give("hey robot")

    def finish(self, words: str, tension: float = 0.0, distance: float = 0.0) -> str:
        """Give a command and carry it out; returns what went wrong, or an empty string."""
        ticket = self.give(words, tension, distance)
        if not ticket.reply.result(0).accepted:
            return f"refused: {ticket.reply.result(0).message}"
        if not self.until(ticket.ended.done, limit=90.0):
            return "never ended"
        outcome = ticket.ended.result(0)
        return "" if outcome.kind == "succeeded" else f"{outcome.kind}: {outcome.reason}"

    @property
    def is_moving(self) -> bool:
        """The controller carries out a command, or brakes."""
        return self.executor.view.life.state in IN_MOTION

    @property
    def planner_joints(self) -> Array:
        """Planning configuration that the robot is led to or held at [rad]. Shape (9,)."""
        held = self.executor.view.setpoint
        return planning_joints(self.robot.target if held is None else held)[0]

    def along(self, kind: PhaseKind, path: Path, speed: float) -> Phase:
        """Phase along a path as fast as the joints can follow, up to `speed` [m/s]."""
        return along(self.planner, kind, path, speed)

    @property
    def rcm_error(self) -> float:
        """Distance of the shaft, as it truly is, from the trocar [m]."""
        return self._gauge(self.robot.reading.position + self.error).error

    @property
    def tip_error(self) -> float:
        """Distance of the tip, as it truly is, from where its course has it now [m]."""
        true = self._tip(self.robot.reading.position + self.error)
        return float(np.linalg.norm(true - self._tip(self.robot.target)))

    @property
    def tip(self) -> Array:
        """Tip as it truly is, base frame, [m]. Shape (3,)."""
        return self._tip(self.robot.reading.position + self.error)

    def _tip(self, joints: Array) -> Array:
        q, _ = planning_joints(joints)
        return Configuration(self.planner.model, q).frames[chain.TIP, :, 3]

    def __enter__(self) -> Rig:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.robot.close()


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
    poses = np.tile(grasp_ways(config.scene)[0].T_base_tip, (count, 1, 1))
    for T in poses:
        direction = rng.normal(size=3)
        away = 0.95 * config.scene.workspace_radius * rng.uniform() ** (1.0 / 3.0)
        T[:3, 3] = config.scene.workspace_centre + away * direction / np.linalg.norm(direction)
        T[:3, :3] = turned(rng.uniform(-spread, spread, 3)) @ T[:3, :3]
    return poses
