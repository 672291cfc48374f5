# SPDX-License-Identifier: BSD-3-Clause
"""The commands that the robot takes from a voice, as its controller's table has them."""

from __future__ import annotations

from rst_control.commands.table import COMMANDS
from voice_assist.config import CommandsConfig
from voice_assist.config.commands import AmountCommand
from voice_assist.config.pedal import PedalConfig
from voice_assist.errors import CommandsError

_KNOWN = [spec.phrase for spec in COMMANDS.values() if not spec.is_by_hand_only]


def require_known(config: CommandsConfig) -> None:
    """Refuse settings that call what the robot does not take from a voice.

    Raises:
        CommandsError: Names the phrase's entry and what may be called.
    """
    for index, command in enumerate(config.commands):
        key = f"commands.commands[{index}].command"
        called = command.called if isinstance(command, AmountCommand) else command.command
        if called and called not in _KNOWN:
            raise CommandsError(key, called, f'"" or one of {", ".join(_KNOWN)}')
        if isinstance(command, AmountCommand):
            units = [unit for amount in COMMANDS[called].amounts for unit in amount.spoken_units]
            allowed = " or ".join(units) or "no amount"
            if command.slot.unit not in units:
                raise CommandsError(key, command.command, f"{allowed} with {called!r}")


def require_pedal_commands(config: PedalConfig) -> None:
    """Refuse pedals that send what the robot does not take.

    Raises:
        CommandsError: Names the binding and what may be sent.
    """
    for index, binding in enumerate(config.bindings):
        if binding.command and binding.command not in _KNOWN:
            key = f"pedal.bindings[{index}].command"
            raise CommandsError(key, binding.command, f"one of {', '.join(_KNOWN)}")
