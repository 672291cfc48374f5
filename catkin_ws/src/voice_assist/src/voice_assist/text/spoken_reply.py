# SPDX-License-Identifier: BSD-3-Clause
"""The controller's replies in words that a loudspeaker may say beside the microphone.

A reply names what can be said next. Read aloud it would say it, and "stop" stops from anyone.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from voice_assist.text.normalize import normalize

UNITS = {"N": "newton", "mm": "millimetres", "m": "metres", "ms": "milliseconds", "s": "seconds"}
OTHER_WORDS = {  # beginnings of words that commands are made of, and what says the same
    "stopp": "halted",
    "stop": "halts",
    "pulled": "drawn",
    "pull": "draws",
    "more": "further",
    "less": "back",
    "tense": "tightens",
    "released": "opened",
    "release": "opens",
    "terminate": "ends",
    "robot": "arm",
}
ASIDE = re.compile(r"\([^)]*\)|\"[^\"]*\"|(?<!\w)'[^']*'(?!\w)")  # in brackets, or quoted
ADVICE = re.compile(r"say\b", re.IGNORECASE)
UNIT = re.compile(rf"(?<=\d )({'|'.join(UNITS)})\b")
WORD = re.compile(r"[A-Za-z]+")
LEFT_ALONE = 3  # letters that a word of a command needs at least to be looked for


def spoken_reply(message: str, phrases: Iterable[str]) -> str:
    """A reply without advice, quotations and the words of commands, to be said aloud.

    Args:
        message: As the controller words it.
        phrases: Of all commands.

    Returns:
        Text; empty where nothing is left.
    """
    words = {word for phrase in phrases for word in normalize(phrase) if len(word) >= LEFT_ALONE}
    said = []
    for clause in ASIDE.sub("", message).split(";"):
        plain = UNIT.sub(lambda unit: UNITS[unit[0]], clause.strip())
        if not ADVICE.match(plain):
            said.append(WORD.sub(lambda word: _reworded(word[0], words), plain))
    return "; ".join(filter(None, (" ".join(clause.split()) for clause in said)))


def _reworded(word: str, known: Iterable[str]) -> str:
    low = word.lower()
    if not any(low.startswith(one) for one in known):
        return word
    return next((other for begun, other in OTHER_WORDS.items() if low.startswith(begun)), "")
