# SPDX-License-Identifier: BSD-3-Clause
"""The strict stand-in for the real drivers, without ROS: docs/reference/kinova-drivers.md."""

from rst_control.kinova.stand_in.config import StandInConfig, load_stand_in_config
from rst_control.kinova.stand_in.goals import Goal, GoalHandle, GoalState
from rst_control.kinova.stand_in.simulated_robot import ArmFeedback, KinovaRobot, as_driven
from rst_control.kinova.stand_in.waypoints import Point

__all__ = [
    "ArmFeedback",
    "Goal",
    "GoalHandle",
    "GoalState",
    "KinovaRobot",
    "Point",
    "StandInConfig",
    "as_driven",
    "load_stand_in_config",
]
