# SPDX-License-Identifier: BSD-3-Clause
"""devices.yaml: the calls that spoken commands may make, and nothing else."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import yaml

from typed_config import choice, items, load_config, number, text
from voice_assist.config.commands import CommandsConfig
from voice_assist.errors import CommandsError

FILE: Final = "devices.yaml"
NAME: Final = re.compile(r"/?[A-Za-z]\w*(/[A-Za-z]\w*)*")
TYPE: Final = re.compile(r"[a-z][a-z0-9_]*/[A-Za-z]\w*")
# Name spaces of the robot, of its drivers and of this system: what moves is no device.
OWN: Final = frozenset(
    (
        *("rst_control", "robot", "controller", "voice_assist", "session_log"),
        *("my_gen3", "gen3", "base", "openrst", "kinova_bridge", "kinova_guard", "torque_tension"),
        *("joint_states", "joy"),
    )
)


@dataclass(frozen=True, kw_only=True)
class DeviceCallConfig:
    """One call."""

    phrase: str = text()
    kind: str = choice("service", "topic", "action")
    target: str = text()
    type: str = text()
    arguments: str = text()
    within: float = number(0.05, 60.0, "s")
    on_stop: str = text(may_be_empty=True)

    def __post_init__(self) -> None:
        """Check what no key shows alone.

        Raises:
            CommandsError: A name is none, is the robot's, or the arguments are no mapping.
        """
        if not NAME.fullmatch(self.target):
            raise CommandsError("target", self.target, "a name of ROS, such as /theatre/light")
        if own := OWN & set(self.target.split("/")):
            allowed = f"a device: {min(own)} is the robot's or this system's own"
            raise CommandsError("target", self.target, allowed)
        if not TYPE.fullmatch(self.type):
            raise CommandsError("type", self.type, "a type of ROS, such as std_srvs/SetBool")
        if self.on_stop == self.phrase:
            raise CommandsError("on_stop", self.on_stop, "another phrase than its own")
        try:
            is_mapping = isinstance(yaml.safe_load(self.arguments), dict)
        except (yaml.YAMLError, RecursionError, ValueError):
            is_mapping = False
        if not is_mapping:
            raise CommandsError("arguments", self.arguments, 'YAML of a mapping, such as "{}"')

    @property
    def values(self) -> dict[str, Any]:
        """The arguments by name."""
        found: dict[str, Any] = yaml.safe_load(self.arguments)
        return found


@dataclass(frozen=True, kw_only=True)
class DevicesConfig:
    """All calls."""

    calls: tuple[DeviceCallConfig, ...] = items(1, 100)

    def __post_init__(self) -> None:
        """Check what no single call shows.

        Raises:
            CommandsError: A phrase is given twice, or what undoes a call is not listed.
        """
        phrases = [call.phrase for call in self.calls]
        for index, call in enumerate(self.calls):
            if call.phrase in phrases[:index]:
                raise CommandsError(f"calls[{index}].phrase", call.phrase, "a phrase given once")
            if call.on_stop and call.on_stop not in phrases:
                raise CommandsError(f"calls[{index}].on_stop", call.on_stop, "one of the phrases")

    def get(self, phrase: str) -> DeviceCallConfig | None:
        """The call of a phrase."""
        return next((call for call in self.calls if call.phrase == phrase), None)


def devices_config(data: Mapping[str, Any]) -> DevicesConfig:
    """Build the settings from a mapping, as the parameter server gives it."""
    return load_config(DevicesConfig, data, FILE)


def require_harmless(devices: DevicesConfig, commands: CommandsConfig) -> None:
    """Refuse calls whose phrase moves or stops the robot, or cannot be said.

    Raises:
        CommandsError: Names the call.
    """
    for index, call in enumerate(devices.calls):
        key = f"devices.calls[{index}].phrase"
        if call.phrase not in commands.phrases:
            raise CommandsError(key, call.phrase, "a phrase of commands.yaml")
        command = commands.get(call.phrase)
        if command.is_motion or command.is_halt or command.command:
            allowed = 'of commands.yaml with is_motion false, is_halt false and command ""'
            raise CommandsError(key, call.phrase, allowed)
