# SPDX-License-Identifier: BSD-3-Clause
"""Reads commands from words; the one place in which words become a command."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Final

from rst_control.commands.request import Request
from rst_control.commands.spec import STOP, CommandSpec, Role
from rst_control.commands.table import COMMANDS
from rst_control.types import Reason, Rejected

MAX_LENGTH: Final = 200  # characters of a command with its spaces; the longest one has 15
MAX_ECHOED: Final = 80  # characters of an unknown command that a refusal repeats
_SPACES = re.compile(r"[ \t\r\n]+")
_WORD = re.compile(r"\w+")
_AMOUNT = re.compile(r" ([+-]?[0-9]+(?:[.][0-9]+)?) ?([a-z]+)$", re.ASCII)  # behind a phrase

Table = Mapping[str, CommandSpec]


def read_request(
    words: str, tension: float = 0.0, distance: float = 0.0, commands: Table = COMMANDS
) -> Request | Rejected:
    """Command in words with its amounts, or why it is none.

    Args:
        words: The command; an amount may stand behind it: "pull more 2 mm".
        tension: [N], 0: as configured.
        distance: [m], 0: as configured.
        commands: All commands by their phrases.
    """
    command = read_command(words, commands)
    if command is None:
        return unknown(words, commands=commands)
    if command.role is Role.STOP:
        return Request(command)
    _, said = _parted(words)
    if said is not None:
        return _with_amount(command, said, tension, distance)
    if command.plan is None:
        return Request(command)
    try:
        return Request(command, tension, distance)
    except ValueError as error:
        return Rejected(Reason.BAD_AMOUNT, str(error))


def _with_amount(
    command: CommandSpec, said: tuple[str, str], tension: float, distance: float
) -> Request | Rejected:
    """A command with the number and the unit that were said behind it, or why it takes none."""
    (number, unit), value = said, float(said[0])
    units = {u.lower(): (a, u) for a in command.amounts for u in a.spoken_units}
    given = f"{number} {unit}"
    if tension or distance:
        words = f"one amount, not {given} in words and another beside them"
        return Rejected(Reason.BAD_AMOUNT, words)
    if unit not in units:
        allowed = " or ".join(name for _, name in units.values()) or "no amount"
        words = f'"{command.phrase}" takes {allowed}, not {given}'
        return Rejected(Reason.BAD_AMOUNT, words)
    amount, name = units[unit]
    if not (math.isfinite(value) and value > 0.0):
        words = f'the {amount.name} of "{command.phrase}" must be above 0 {name}'
        return Rejected(Reason.BAD_AMOUNT, f"{words}, not {number} {name}")
    return Request(command, **{amount.name: value * amount.spoken_units[name]})


def read_command(words: str, commands: Table = COMMANDS) -> CommandSpec | None:
    """Command that the words are; None where they are none.

    Case and spaces do not matter, nor does an amount behind the phrase. A text that is longer than
    MAX_LENGTH, or holds anything but ASCII, is no command, whatever it looks like: only a stop is
    read more kindly.
    """
    if is_stop(words):
        return commands[STOP]
    if len(words) > MAX_LENGTH or not words.isascii():
        return None
    return commands.get(_parted(words)[0])


def _parted(words: str) -> tuple[str, tuple[str, str] | None]:
    """Phrase of a command in lower case, and the number and the unit behind it; None: neither."""
    plain = _SPACES.sub(" ", words.lower()).strip(" ")
    found = _AMOUNT.search(plain)
    if found is None:
        return plain, None
    return plain[: found.start()], (found[1], found[2])


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
