# SPDX-License-Identifier: BSD-3-Clause
"""Puts the parts of the controller together from its settings."""

from __future__ import annotations

from collections.abc import Callable

from rst_control.config import MotionConfig
from rst_control.configuration import Configuration, planning_joints
from rst_control.desk import Verify
from rst_control.executor import Executor
from rst_control.motion import MotionMaker
from rst_control.mover import Mover
from rst_control.planner import Planner
from rst_control.rcm import rcm_state
from rst_control.robot_model import RobotModel
from rst_control.types import Vector, frozen_array
from rst_control.verification import Verifier
from rst_control.watchdogs import WatchdogLimits, Watchdogs


def make_executor(
    config: MotionConfig, model: RobotModel, clear_fault: Callable[[], None]
) -> Executor:
    """Make the executor for a robot.

    Args:
        config: Settings.
        model: The robot.
        clear_fault: Asks the robot to take set-points again.
    """
    settings = config.controller
    limits = WatchdogLimits(
        settings.watchdogs, config.rcm.measured_tolerance, settings.tension.limit
    )
    mover = Mover(MotionMaker(settings))
    return Executor(
        Watchdogs(limits), rcm_gauge(config, model), mover, clear_fault, 1.0 / settings.rate
    )


def make_verify(config: MotionConfig, model: RobotModel) -> Verify:
    """Make the verification for a robot, with everything compiled that it will call."""
    planner = Planner(model, config)
    planner.warm_up()
    return Verifier(planner)


def rcm_gauge(config: MotionConfig, model: RobotModel) -> Callable[[Vector], float]:
    """Function that gives the shaft's distance from the trocar [m] for the robot's joints (10,)."""
    trocar = frozen_array(config.scene.trocar, 3)

    def gauge(joints: Vector) -> float:
        q, _ = planning_joints(joints)
        return rcm_state(Configuration(model, q), trocar).error

    return gauge
