# SPDX-License-Identifier: BSD-3-Clause
"""The commands that the robot takes from a voice, as its controller's table has them."""

from __future__ import annotations

from rst_control.commands.parser import read_request
from rst_control.commands.request import Request
from rst_control.commands.table import COMMANDS
from rst_control.types import Reason, Rejected
from voice_assist.config import CommandsConfig
from voice_assist.config.pedal import PedalConfig
from voice_assist.errors import CommandsError

_KNOWN = [spec.phrase for spec in COMMANDS.values() if not spec.is_by_hand_only]


def require_known(config: CommandsConfig) -> None:
    """Refuse settings that call what the robot does not take from a voice.

    Raises:
        CommandsError: Names the phrase's entry and what may be called.
    """
    for index, command in enumerate(config.commands):
        key, request = f"commands.commands[{index}].command", read_request(command.command)
        known = isinstance(request, Request) and request.command.phrase in _KNOWN
        if command.command and not known:
            allowed = f'"" or one of {", ".join(_KNOWN)}'
            if isinstance(request, Rejected) and request.reason is Reason.BAD_AMOUNT:
                allowed = request.words
            raise CommandsError(key, command.command, allowed)


def require_pedal_commands(config: PedalConfig) -> None:
    """Refuse pedals that send what the robot does not take.

    Raises:
        CommandsError: Names the binding and what may be sent.
    """
    for index, binding in enumerate(config.bindings):
        if binding.command and binding.command not in _KNOWN:
            key = f"pedal.bindings[{index}].command"
            raise CommandsError(key, binding.command, f"one of {', '.join(_KNOWN)}")
