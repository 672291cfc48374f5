# SPDX-License-Identifier: BSD-3-Clause
"""Puts the parts of the controller together from its settings."""

from __future__ import annotations

from collections.abc import Callable

from rst_control.config import MotionConfig
from rst_control.execution.executor import Executor
from rst_control.execution.motion import MotionMaker
from rst_control.execution.setpoint import SetpointState
from rst_control.kinematics.robot_model import RobotModel
from rst_control.registration.trocar_context import ActiveTrocarContext, TrocarContext
from rst_control.robot.backend import RobotBackend
from rst_control.robot.joint_correction import JointCorrection
from rst_control.robot.play_compensation import PlayCompensation
from rst_control.supervision.node_liveness import NodeLiveness
from rst_control.supervision.plausibility import SensorWatch, max_joint_speed
from rst_control.supervision.tension_trust import TensionTrust
from rst_control.supervision.watchdogs import WatchdogLimits, Watchdogs
from rst_control.tension.grasp_response import GraspResponse
from rst_control.types import State


def make_executor(
    config: MotionConfig,
    context: ActiveTrocarContext,
    clear_fault: Callable[[], None],
    liveness: NodeLiveness | None = None,
) -> Executor:
    """Make the executor for a robot.

    Args:
        config: Settings.
        context: Measures the shaft's distance from the trocar.
        clear_fault: Asks the robot to take set-points again.
        liveness: What became of the other nodes; None: nobody watches them.
    """
    settings = config.controller
    limits = WatchdogLimits(
        settings.watchdogs,
        config.rcm.measured_tolerance,
        settings.tension.limit,
        settings.tension.delay,
    )
    response = GraspResponse(settings.tension, settings.watchdogs.sensors.tension_deficit)
    trust = TensionTrust(settings.tension, settings.watchdogs.sensors, context.tip, response)
    setpoint_state = SetpointState(MotionMaker(settings, response))
    period = 1.0 / settings.rate
    sensors = SensorWatch(settings, max_joint_speed(config.limits))
    watchdogs = Watchdogs(limits, sensors, liveness or NodeLiveness())
    return Executor(watchdogs, context.trocar_pose, setpoint_state, clear_fault, period, trust)


def make_trocar_context(config: MotionConfig, model: RobotModel) -> TrocarContext:
    """Make planning, verification and measurement for a robot, with all compiled that they call.

    Raises:
        TrocarOutOfReach: The arm cannot take the shaft to `scene.trocar`.
    """
    context = TrocarContext(config, model)
    context.verify.warm_up()
    return context


def compensated(
    robot: RobotBackend, config: MotionConfig, state: Callable[[], State]
) -> RobotBackend:
    """The robot behind all that makes up for its friction and play, as the settings ask for.

    Args:
        robot: What moves.
        config: Settings.
        state: What the controller is doing.
    """
    if config.controller.joint_correction.is_on:
        robot = JointCorrection(robot, config, state)
    if config.controller.tool_play.is_on:
        robot = PlayCompensation(robot, config, state)
    return robot
