# SPDX-License-Identifier: BSD-3-Clause
"""What a text of commands.yaml stands for: `[optional]` words, and `{slots}` of an amount."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from typed_config import choice, flag, number, text
from voice_assist.errors import CommandsError
from voice_assist.text.amounts import (
    DECIMALS,
    MOST,
    UNITS,
    spoken_amount,
    spoken_value,
    spoken_with_point,
)

_PART = re.compile(r"\[([^\[\]{}]*)\]|([^\[\]{}]+)|\{([^\[\]{}]*)\}")


@dataclass(frozen=True, kw_only=True)
class SlotConfig:
    """The amounts that one kind of command takes."""

    name: str = text()
    unit: str = choice(*UNITS)
    values: tuple[float, ...] = number(0.001, MOST, "mm or N")
    ask_above: float = number(0.0, MOST, "mm or N")
    needs_unit: bool = flag()

    def __post_init__(self) -> None:
        """Check what no key shows alone.

        Raises:
            CommandsError: There is no value, one is there twice or has too many decimals, or a
                part of one is another.
        """
        values = list(self.values)
        if not values or len(set(values)) < len(values):
            raise CommandsError("values", values, "one number or more, each once")
        if any(value != round(value, DECIMALS) for value in values):
            raise CommandsError("values", values, f"numbers of at most {DECIMALS} decimals")
        said = [self.number(value) for value in values]
        for words, part in product(said, said):
            begins = not self.needs_unit and words.startswith(f"{part} ")
            if words.endswith(f" {part}") or begins:
                allowed = f"numbers of which none is part of another, as {part!r} is of {words!r}"
                raise CommandsError("values", values, allowed)

    @property
    def allowed(self) -> str:
        """All amounts in words."""
        return ", ".join(spoken_amount(value, self.unit) for value in self.values)

    def number(self, value: float) -> str:
        """The words of one of the numbers."""
        return spoken_value(value) if self.needs_unit else spoken_with_point(value)

    def said(self, value: float) -> tuple[str, ...]:
        """How one of the amounts is said, the shortest way first.

        A number with a point needs no unit where the slot says so. A whole number then gets a point
        as well: "two point zero".
        """
        whole = spoken_amount(value, self.unit)
        if self.needs_unit:
            return (whole,)
        if value == int(value):
            return whole, spoken_with_point(value)
        short = spoken_value(value)
        return (short, f"zero {short}", whole) if value < 1.0 else (short, whole)


def without_brackets(key: str, spelling: str) -> tuple[str, ...]:
    """All texts that a spelling with `[optional]` words stands for, the shortest first.

    Raises:
        CommandsError: Its brackets do not match.
    """
    parts = list(_parts(key, spelling))
    choices = [("", words) if is_optional else (words,) for words, is_optional in parts]
    texts = (" ".join(" ".join(some).split()) for some in product(*choices))
    return tuple(dict.fromkeys(texts))


def slot_of(key: str, phrase: str, slots: Sequence[SlotConfig]) -> SlotConfig | None:
    """The slot of a phrase; None: it has none.

    Raises:
        CommandsError: It has several, or one that is not declared.
    """
    found = [part[3] for part in _PART.finditer(phrase) if part[3] is not None]
    if not found:
        return None
    names = {slot.name: slot for slot in slots}
    allowed = "at most one of " + (", ".join(f"{{{name}}}" for name in names) or "no slots")
    if len(found) > 1 or found[0] not in names:
        raise CommandsError(key, phrase, f"{allowed}, as slots declares them")
    return names[found[0]]


def _parts(key: str, spelling: str) -> Iterator[tuple[str, bool]]:
    """Parts of a spelling, and whether each is optional."""
    if _PART.sub("", spelling):
        raise CommandsError(key, spelling, "matching brackets, none within another")
    for part in _PART.finditer(spelling):
        if part[1] is not None:
            yield part[1], True
        else:
            yield part[0], False
