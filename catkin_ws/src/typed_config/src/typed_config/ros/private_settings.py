# SPDX-License-Identifier: BSD-3-Clause
"""A node's settings from its private parameters, and the model of the robot."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TypeVar

import rospy

from typed_config.errors import ConfigError, Missing
from typed_config.loader import load_config, load_file

T = TypeVar("T")


def private_settings(kind: type[T], path: Path) -> T:
    """Build the dataclass `kind` from the parameters of this node; from a file where it has none.

    Raises:
        typed_config.ConfigError: A key is not as it must be.
    """
    names = [field.name for field in dataclasses.fields(kind)]  # type: ignore[arg-type]
    given = {name: rospy.get_param(f"~{name}") for name in names if rospy.has_param(f"~{name}")}
    if given:
        return load_config(kind, given, path.name)
    rospy.loginfo("no private parameters; the settings are those of the package's file")
    return load_file(kind, path)


def robot_description() -> str:
    """URDF text of the robot, as its launch sets it for all nodes.

    Raises:
        typed_config.ConfigError: There is none.
    """
    text = rospy.get_param("robot_description", Missing())
    if not isinstance(text, str):
        allowed = "the text of a URDF, which robot.launch and kinova.launch set"
        raise ConfigError("robot_description", text, allowed)
    return text
