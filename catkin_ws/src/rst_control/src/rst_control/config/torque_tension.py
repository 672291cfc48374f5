# SPDX-License-Identifier: BSD-3-Clause
"""torque_tension.yaml: how the tissue's pull is estimated from joint torques, and when not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from rst_control.config.believed import NodeNames
from rst_control.config.motion import CONFIG_FOLDER, EMPTY
from rst_control.types import Arm
from typed_config import integer, load_file, number, require, text

TORQUE_TENSION_FILE = CONFIG_FOLDER / "torque_tension.yaml"


@dataclass(frozen=True, kw_only=True)
class TorqueErrorConfig:
    """How wrong a joint torque and its model may be: standard deviations."""

    noise: Arm = number(0.0, 5.0, "N m")
    offset: Arm = number(0.0, 10.0, "N m")
    friction: Arm = number(0.0, 5.0, "N m")
    gain: float = number(0.0, 0.2, "")
    loads: tuple[float, float] = number(0.0, 20.0, "N")
    model: float = number(0.0, 0.5, "")
    tilt: float = number(0.0, 0.2, "rad")
    tool_mass: float = number(0.0, 2.0, "kg")
    inertia: float = number(0.0, 2.0, "")
    trocar_friction: float = number(0.0, 5.0, "N")


@dataclass(frozen=True, kw_only=True)
class TareConfig:
    """When the bias of the torques is taken, and how far from there it holds."""

    time: float = number(0.01, 5.0, "s")
    opening: float = number(0.0, EMPTY, "rad")  # all jaws open further: MIN_OPEN
    at_rest_speed: float = number(1e-4, 0.1, "rad/s")
    holds_within: float = number(0.001, 3.2, "rad")
    holds_for: float = number(1.0, 3600.0, "s")


@dataclass(frozen=True, kw_only=True)
class TorqueBelievedConfig(NodeNames):
    """Nodes whose messages count for the estimator; [] stands for anybody."""

    robot: tuple[str, ...] = text()
    controller: tuple[str, ...] = text()


@dataclass(frozen=True, kw_only=True)
class TorqueTensionConfig:
    """torque_tension.yaml."""

    RENAMED: ClassVar[Mapping[str, str]] = {
        "least_readings": "min_readings",
        "most_sigma": "max_sigma",
        "most_misfit": "max_misfit",
        "pull_direction": "",  # that of the scene counts
    }

    effort_sign: int = integer(-1, 1)
    tool_mass: float = number(0.0, 3.0, "kg")
    rate: float = number(5.0, 500.0, "Hz")
    filter_time: float = number(0.0, 1.0, "s")
    gap: float = number(0.002, 1.0, "s")
    fastest: float = number(0.001, 2.0, "rad/s")
    max_sigma: float = number(0.01, 5.0, "N")
    max_misfit: float = number(1.0, 100.0, "")
    min_readings: int = integer(1, 1000)
    error: TorqueErrorConfig
    tare: TareConfig
    believed: TorqueBelievedConfig

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require(self.effort_sign != 0, "effort_sign", self.effort_sign, "1 or -1")


def load_torque_tension(path: Path = TORQUE_TENSION_FILE) -> TorqueTensionConfig:
    """Read the settings.

    Raises:
        typed_config.ConfigError: A key is unknown, missing or out of range; names it and its file.
    """
    return load_file(TorqueTensionConfig, path)
