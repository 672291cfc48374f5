# SPDX-License-Identifier: BSD-3-Clause
"""Move: RCM-constrained motion of a Gen3 with an OpenRST forceps (Robotic Surgical Tool).

A name below is loaded when it is first used: importing the package alone compiles nothing and opens
no simulator. `examples/` shows them at work.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rst_control.admission.command_queue import CommandQueue
    from rst_control.assembly import make_executor, make_trocar_context
    from rst_control.commands.parser import read_request
    from rst_control.config import load_motion_config, load_simulation_config
    from rst_control.kinematics.configuration import Configuration
    from rst_control.kinematics.rcm import rcm_state
    from rst_control.kinematics.robot_model import load_robot
    from rst_control.planning.planner import Planner
    from rst_control.registration.trocar_context import ActiveTrocarContext
    from rst_control.robot.backend import RobotBackend
    from rst_control.simulation.pybullet_robot import PybulletRobot
    from rst_control.types import Measurement, Setpoint

__all__ = [
    "ActiveTrocarContext",
    "CommandQueue",
    "Configuration",
    "Measurement",
    "Planner",
    "PybulletRobot",
    "RobotBackend",
    "Setpoint",
    "load_motion_config",
    "load_robot",
    "load_simulation_config",
    "make_executor",
    "make_trocar_context",
    "rcm_state",
    "read_request",
]

_HOMES = {
    "ActiveTrocarContext": "registration.trocar_context",
    "CommandQueue": "admission.command_queue",
    "Configuration": "kinematics.configuration",
    "Measurement": "types",
    "Planner": "planning.planner",
    "PybulletRobot": "simulation.pybullet_robot",
    "RobotBackend": "robot.backend",
    "Setpoint": "types",
    "load_motion_config": "config",
    "load_robot": "kinematics.robot_model",
    "load_simulation_config": "config",
    "make_executor": "assembly",
    "make_trocar_context": "assembly",
    "rcm_state": "kinematics.rcm",
    "read_request": "commands.parser",
}


def __getattr__(name: str) -> object:
    """Load a public name from its room."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
