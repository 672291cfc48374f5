# SPDX-License-Identifier: BSD-3-Clause
"""Reads commands from words; the one place in which words become a command."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from rst_control.commands.request import Request
from rst_control.commands.spec import STOP, CommandSpec
from rst_control.commands.table import COMMANDS
from rst_control.types import Reason, Rejected

MAX_LENGTH: Final = 200  # characters of a command with its spaces; the longest one has 15
MAX_ECHOED: Final = 80  # characters of an unknown command that a refusal repeats
_SPACES = re.compile(r"[ \t\r\n]+")
_WORD = re.compile(r"\w+")

Table = Mapping[str, CommandSpec]


def read_request(
    words: str, tension: float = 0.0, distance: float = 0.0, commands: Table = COMMANDS
) -> Request | Rejected:
    """Command in words with its amounts, or why it is none.

    Args:
        words: The command.
        tension: [N], 0: as configured.
        distance: [m], 0: as configured.
        commands: All commands by their phrases.
    """
    command = read_command(words, commands)
    if command is None:
        return unknown(words, commands=commands)
    if command.plan is None:
        return Request(command)
    try:
        return Request(command, tension, distance)
    except ValueError:
        return Rejected(Reason.BAD_AMOUNT, "tension and distance must be numbers from 0 up")


def read_command(words: str, commands: Table = COMMANDS) -> CommandSpec | None:
    """Command that the words are; None where they are none.

    Case and spaces do not matter. A text that is longer than MAX_LENGTH, or holds anything but
    ASCII, is no command, whatever it looks like: only a stop is read more kindly.
    """
    if is_stop(words):
        return commands[STOP]
    if len(words) > MAX_LENGTH or not words.isascii():
        return None
    return commands.get(_SPACES.sub(" ", words.lower()).strip(" "))


def is_stop(words: str) -> bool:
    """Whether the words say "stop" and nothing else, once or more, with any marks around.

    Of a text too long to be a command the beginning decides: what begins as a stop stops.
    """
    said = _WORD.findall(words[:MAX_LENGTH].lower())
    if len(words) > MAX_LENGTH and len(said) > 1:
        said.pop()  # it may be cut
    return bool(said) and set(said) == {STOP}


def unknown(words: str, length: int = 0, commands: Table = COMMANDS) -> Rejected:
    """Refusal of words that are no command, with the list of those that are.

    Args:
        words: What was said, or its beginning.
        length: Of all that was said [bytes], where `words` is only its beginning.
        commands: All commands by their phrases.
    """
    oddity = f" of {length} bytes, allowed: {MAX_LENGTH}" if length else _oddity(words)
    reply = f"unknown command {shown(words)!r}{oddity}; say one of: {', '.join(commands)}"
    return Rejected(Reason.UNKNOWN_COMMAND, reply)


def _oddity(words: str) -> str:
    """What keeps words from being a command, apart from what they say; empty: nothing does."""
    if len(words) > MAX_LENGTH:
        return f" of {len(words)} characters, allowed: {MAX_LENGTH}"
    if words.isascii():
        return ""
    first = next(c for c in words if not c.isascii())
    return f" with U+{ord(first):04X}, which no command has"


def shown(words: str, longest: int = MAX_ECHOED) -> str:
    """Beginning of a text of others, on one line, as it may be repeated to people."""
    return "".join(c if c.isprintable() else "?" for c in words[:longest])
