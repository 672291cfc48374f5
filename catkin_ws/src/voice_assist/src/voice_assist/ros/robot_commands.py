# SPDX-License-Identifier: BSD-3-Clause
"""The commands that the robot takes from a voice, as its controller's table has them."""

from __future__ import annotations

from rst_control.commands.table import COMMANDS
from voice_assist.config import CommandsConfig
from voice_assist.errors import CommandsError


def require_known(config: CommandsConfig) -> None:
    """Refuse settings that call what the robot does not take from a voice.

    Raises:
        CommandsError: Names the phrase's entry and what may be called.
    """
    known = [spec.phrase for spec in COMMANDS.values() if not spec.is_by_hand_only]
    for index, command in enumerate(config.commands):
        if command.command and command.command not in known:
            key = f"commands.commands[{index}].command"
            raise CommandsError(key, command.command, f'"" or one of {", ".join(known)}')
