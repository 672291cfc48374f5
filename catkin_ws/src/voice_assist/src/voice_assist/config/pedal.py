# SPDX-License-Identifier: BSD-3-Clause
"""Settings of the pedals, from `config/pedal.yaml`."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from typed_config import choice, items, load_config, number, text
from voice_assist.errors import CommandsError

FILE: Final = "pedal.yaml"
INPUT: Final = re.compile(r"(button|axis) (\d{1,3})")


@dataclass(frozen=True, kw_only=True)
class BindingConfig:
    """What one button or axis does."""

    input: str = text()
    above: float = number(-1e6, 1e6, "")
    does: str = choice("command", "talk", "mute", "dead_man")
    command: str = text(may_be_empty=True)

    def __post_init__(self) -> None:
        """Check what no key shows alone.

        Raises:
            CommandsError: The input is none, or a command is missing or too much.
        """
        if not INPUT.fullmatch(self.input):
            raise CommandsError("input", self.input, "button N or axis N, N from 0 to 999")
        if (self.does == "command") is not bool(self.command):
            allowed = "a command where does is command, else empty"
            raise CommandsError("command", self.command, allowed)
        if self.above == 0.0:
            raise CommandsError("above", self.above, "another number than 0: an axis rests there")


@dataclass(frozen=True, kw_only=True)
class PedalConfig:
    """All settings of the pedals."""

    source: str = choice("joy", "evdev")
    topic: str = text()
    device: str = text(may_be_empty=True)
    look_again: float = number(0.1, 60.0, "s")
    silent_after: float = number(0.0, 60.0, "s")
    bindings: tuple[BindingConfig, ...] = items(1, 50)

    def __post_init__(self) -> None:
        """Check what no key shows alone.

        Raises:
            CommandsError: Two bindings have one input, there are two gates or dead-men, or no name
                is given.
        """
        counts = Counter(binding.input for binding in self.bindings)
        for name, count in counts.items():
            if count > 1:
                raise CommandsError("bindings", name, "each input once")
        for kinds in (("talk", "mute"), ("dead_man",)):
            found = [binding.input for binding in self.bindings if binding.does in kinds]
            if len(found) > 1:
                raise CommandsError(
                    "bindings", found, f"at most one that does {' or '.join(kinds)}"
                )
        if self.source == "evdev" and not self.device:
            raise CommandsError("device", self.device, "a name, as source is evdev")


def pedal_config(data: Mapping[str, Any]) -> PedalConfig:
    """Build the settings from a mapping, as the parameter server gives it."""
    return load_config(PedalConfig, data, FILE)
