# SPDX-License-Identifier: BSD-3-Clause
"""The 6-DoF arm of examples/ur5e_openrst."""

from functools import cache
from pathlib import Path

from rst_control.config import CONFIG_FOLDER, MotionConfig
from rst_control.kinematics.robot_model import load_robot
from typed_config import load_config, load_yaml, overlaid

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "ur5e_openrst"
URDF = EXAMPLE / "robot.urdf"
SECTIONS = ("limits", "rcm", "scene", "controller", "collision")


def settings_of(kind, sections):
    """Settings with these sections, as `controller.launch overrides:=...` puts them together."""
    base = {name: load_yaml(CONFIG_FOLDER / f"{name}.yaml") for name in sections}
    own = load_yaml(EXAMPLE / "settings.yaml")
    settings = overlaid(base, {name: own[name] for name in sections if name in own})
    return load_config(kind, settings, "settings.yaml")


@cache
def example():
    """Its settings of motion, and the model."""
    return settings_of(MotionConfig, SECTIONS), load_robot(URDF)
