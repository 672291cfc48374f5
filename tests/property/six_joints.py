# SPDX-License-Identifier: BSD-3-Clause
"""The 6-DoF arm of examples/ur5e_openrst."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from rst_control.config import CONFIG_FOLDER, MotionConfig
from rst_control.kinematics.robot_model import RobotModel, load_robot
from typed_config import load_config, load_yaml, overlaid

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "ur5e_openrst"
URDF = EXAMPLE / "robot.urdf"
SECTIONS = ("limits", "rcm", "scene", "controller", "collision")


@cache
def example() -> tuple[MotionConfig, RobotModel]:
    """Settings, as `controller.launch overrides:=...` puts them together, and the model."""
    base = {name: load_yaml(CONFIG_FOLDER / f"{name}.yaml") for name in SECTIONS}
    settings = overlaid(base, load_yaml(EXAMPLE / "settings.yaml"))
    return load_config(MotionConfig, settings, "settings.yaml"), load_robot(URDF)
