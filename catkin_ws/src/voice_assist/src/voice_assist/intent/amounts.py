# SPDX-License-Identifier: BSD-3-Clause
"""What was said of an amount where no command has it: half a command, a wrong number or unit."""

from __future__ import annotations

from collections.abc import Sequence

from voice_assist.config.commands import AmountCommand
from voice_assist.text.amounts import (
    amount_words,
    before_amount,
    is_of_amount,
    is_unit,
    may_be_of_amount,
)
from voice_assist.text.normalize import Words, normalize

_BETWEEN = frozenset(("a", "an", "and"))  # of an amount: "one and a half", "half a newton"


class AmountTalk:
    """Knows the commands with amounts by their words beside the amount."""

    def __init__(self, commands: Sequence[AmountCommand]) -> None:
        """Take the commands, one for each amount."""
        self._templates: dict[Words, list[AmountCommand]] = {}
        for command in commands:
            beside = _beside(normalize(command.phrase))
            first = self._templates.setdefault(beside, [])
            if all(known.template != command.template for known in first):
                first.append(command)
        self._words = _BETWEEN.union(*self._templates)

    def is_made_of(self, words: Words) -> bool:
        """Whether all words are of a command with an amount, in whatever order."""
        return all(word in self._words or may_be_of_amount(word) for word in words)

    def settled(self, words: Words) -> Words:
        """What stays of a text that goes on: a number may yet become another one.

        Nothing stays of what a halt would still stop.
        """
        return () if self.is_made_of(words) else before_amount(words)

    def refusal(self, words: Words) -> str:
        """What is wrong with an amount, by name; empty: the words are of no command with one."""
        commands = self._templates.get(_beside(words))
        said = amount_words(words)
        if commands is None or not said:
            return ""
        units = sum(is_unit(word) for word in said)
        may_lack = "point" in said and any(not c.slot.needs_unit for c in commands)
        lacks = "is not among its amounts"
        if units == len(said):
            lacks = "has no number"
        elif not units and not may_lack:
            lacks = "has no unit"
        elif any(" ".join(said) in c.slot.said(v) for c in commands for v in c.slot.values):
            lacks = "stands in another place"
        what = f"{' '.join(said)!r} {lacks}"
        allowed = "; ".join(f"{c.template!r} takes {c.slot.allowed}" for c in commands)
        return f"{what}: {allowed}"


def _beside(words: Words) -> Words:
    """The words that are of no amount."""
    return tuple(w for w in words if not is_of_amount(w) and w not in _BETWEEN)
