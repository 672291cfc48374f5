# SPDX-License-Identifier: BSD-3-Clause
"""settings.json of a profile: from which confidence on each command is taken from this person.

A profile makes a motion harder to get, never easier, and a halt easier, never harder, than
commands.yaml has it: whatever the file says, `overlay` keeps that.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from typed_config import items, number, text
from voice_assist.config.commands import NEVER_SURE, CommandConfig, CommandsConfig
from voice_assist.profile.manifest import read_part

NAME = "settings.json"  # in a profile


@dataclass(frozen=True, kw_only=True)
class Setting:
    """The threshold of one command."""

    phrase: str = text()
    least_confidence: float = number(0.0, NEVER_SURE, "")


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Thresholds of all commands in a profile."""

    commands: tuple[Setting, ...] = items(0, 200)

    def get(self, phrase: str) -> float | None:
        """Threshold of a command; None: as commands.yaml has it."""
        found = [s.least_confidence for s in self.commands if s.phrase == phrase]
        return found[0] if found else None


def from_bytes(data: bytes) -> Settings:
    """What `manifest.to_bytes` gave.

    Raises:
        VoiceError: It is something else.
    """
    return read_part(Settings, data, NAME)


def overlay(commands: CommandsConfig, settings: Settings) -> CommandsConfig:
    """The commands with a person's thresholds, where those are on the safe side."""
    return replace(
        commands,
        commands=tuple(_overlaid(c, settings.get(c.phrase)) for c in commands.commands),
    )


def _overlaid(command: CommandConfig, minimum: float | None) -> CommandConfig:
    if minimum is None:
        return command
    base = command.min_confidence
    if command.is_motion:
        minimum = max(minimum, base)
    elif command.is_halt:
        minimum = min(minimum, base)
    return replace(command, min_confidence=minimum)
