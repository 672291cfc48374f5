# SPDX-License-Identifier: BSD-3-Clause
"""kinova_stand_in.yaml: the stand-in for the drivers of the Kinova Gen3 and of OpenRST."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from rst_control.config import CONFIG_FOLDER
from rst_control.types import Arm, Triple
from typed_config import flag, integer, load_file, number, require, text

FILE = "kinova_stand_in.yaml"


@dataclass(frozen=True, kw_only=True)
class CallsConfig:
    """How long the driver waits for the arm to answer each call."""

    stop: float = number(0.0, 1.0, "s")
    validate: float = number(0.0, 1.0, "s")
    clear_faults: float = number(0.0, 1.0, "s")
    execute: float = number(0.0, 1.0, "s")
    speeds: float = number(0.0, 1.0, "s")


@dataclass(frozen=True, kw_only=True)
class TorqueConfig:
    """How the joint torques that the arm reports differ from those that its motors give."""

    sign: float = number(-1.0, 1.0, "")
    noise: Arm = number(0.0, 10.0, "N m")
    offset: Arm = number(-10.0, 10.0, "N m")
    friction: Arm = number(0.0, 10.0, "N m")
    seed: int = integer(0, 2**31)

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require(abs(self.sign) == 1.0, "sign", self.sign, "1 or -1")


@dataclass(frozen=True, kw_only=True)
class DriverConfig:
    """Kinova's driver and the arm's own controller behind it."""

    RENAMED: ClassVar[Mapping[str, str]] = {"least_duration": "min_duration"}

    name: str = text()
    joints: tuple[str, ...] = text()
    feedback_rate: float = number(1.0, 1000.0, "Hz")
    goal_time_tolerance: float = number(0.0, 10.0, "s")
    first_duration: float = number(1e-4, 10.0, "s")
    min_duration: float = number(1e-4, 1.0, "s")
    fault_wait: float = number(0.0, 10.0, "s")
    calls: CallsConfig
    command_period: float = number(0.001, 0.2, "s")
    preprocess_time: float = number(0.0, 10.0, "s")
    preprocess_point: float = number(0.0, 0.1, "s")
    notice_delay: float = number(0.0, 1.0, "s")
    swapped_notices: bool = flag()
    soft_layer: str = text()
    hard_layer: str = text()
    torque: TorqueConfig

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        names = list(self.joints)
        require(len(set(names)) == 7, "joints", names, "seven names that differ")


@dataclass(frozen=True, kw_only=True)
class OpenRstConfig:
    """OpenRST's control node and the tool behind it."""

    name: str = text()
    joints: tuple[str, str, str] = text()
    signs: Triple = number(-1.0, 1.0, "")
    period: float = number(0.0005, 0.1, "s")
    speed: float = number(0.01, 10.0, "rad/s")
    acceleration: float = number(0.1, 100.0, "rad/s^2")
    stops: Triple = number(0.1, 1.65, "rad")
    homing_speed: float = number(0.01, 10.0, "rad/s")
    homing_dwell: float = number(0.0, 10.0, "s")
    tissue_opening: float = number(0.0, 0.5, "rad")
    closed_opening: float = number(0.0, 0.5, "rad")
    held_opening: float = number(0.0, 0.5, "rad")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require(all(abs(s) == 1.0 for s in self.signs), "signs", list(self.signs), "1 or -1 each")
        openings = [self.tissue_opening, self.closed_opening, self.held_opening]
        is_rising = openings[0] < openings[1] < openings[2]
        allowed = "tissue_opening below closed_opening below held_opening"
        require(is_rising, "tissue_opening", openings, allowed)


@dataclass(frozen=True, kw_only=True)
class StandInConfig:
    """All of kinova_stand_in.yaml."""

    force_sensor_topic: str = text(may_be_empty=True)
    driver: DriverConfig
    tool: OpenRstConfig


def load_stand_in_config(folder: Path = CONFIG_FOLDER) -> StandInConfig:
    """Read kinova_stand_in.yaml of a folder.

    Raises:
        typed_config.ConfigError: A key is unknown, missing or out of range; names it.
    """
    return load_file(StandInConfig, folder / FILE)
