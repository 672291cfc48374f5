# SPDX-License-Identifier: BSD-3-Clause
"""Amounts as they are spoken: a number in words with its unit, such as "half a millimetre".

A number or a unit that was heard is taken as it was heard or not at all. So two texts hold the same
amount only where `amount_words` of both are equal.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Final

from voice_assist.text.normalize import Words, spoken_number

# Of each unit how it is said of one, of several, and how else it is said or written.
UNITS: Final = {
    "mm": (
        *("millimetre", "millimetres", "millimeter", "millimeters", "mm"),
        *("mil", "mils", "mill", "mills"),
    ),
    "N": ("newton", "newtons", "n"),
}
MOST: Final = 999  # whole numbers that are read
DECIMALS: Final = 3  # of a number that is said
HALF: Final = 0.5
_UNIT_OF: Final = {word: unit for unit, words in UNITS.items() for word in words}
_OTHER_UNITS: Final = frozenset(
    (
        *("metre", "metres", "meter", "meters", "m", "centimetre", "centimetres", "centimeter"),
        *("centimeters", "cm", "inch", "inches", "foot", "feet", "gram", "grams", "kilogram"),
        *("kilograms", "kg", "kilo", "kilos", "pound", "pounds", "percent", "degree", "degrees"),
    )
)
_SAME_SOUND: Final = {"to": "two", "too": "two", "for": "four", "oh": "zero"}
_MORE_NUMBERS: Final = frozenset(
    (
        *("point", "half", "halves", "quarter", "quarters", "third", "thirds", "hundred"),
        *("thousand", "million", "dozen", "couple", "double", "twice", "triple", "minus", "plus"),
    )
)
_LONGEST: Final = 8  # words of a number


@cache
def _whole() -> dict[Words, int]:
    """Whole numbers by their words."""
    return {tuple(spoken_number(n).split()): n for n in range(MOST + 1)}


@cache
def _numbers() -> frozenset[str]:
    """All words of numbers."""
    return _MORE_NUMBERS.union(*_whole())


def is_unit(word: str) -> bool:
    """Whether a word is a unit, of a command or not."""
    return word in _UNIT_OF or word in _OTHER_UNITS


def is_of_amount(word: str) -> bool:
    """Whether a word is one of a number or a unit."""
    return word in _numbers() or is_unit(word)


def may_be_of_amount(word: str) -> bool:
    """Whether a word is one of those, or sounds like one: "to" as "two"."""
    return is_of_amount(word) or word in _SAME_SOUND


def amount_words(words: Words) -> Words:
    """All words of numbers and units, in their order."""
    return tuple(word for word in words if is_of_amount(word))


def before_amount(words: Words) -> Words:
    """The words up to the first that may belong to a number or a unit."""
    for place, word in enumerate(words):
        if may_be_of_amount(word):
            return words[:place]
    return words


def value_of(words: Words) -> float | None:
    """The number that words are; None: they are none.

    "two", "one point five", "point five", "half", "a half" and "two and a half" are numbers. A word
    that sounds the same counts for a digit: "to" for "two".
    """
    plain = tuple(_SAME_SOUND.get(word, word) for word in words)
    if plain in (("half",), ("a", "half")):
        return HALF
    if plain[-3:] == ("and", "a", "half"):
        whole = _whole().get(plain[:-3])
        return None if whole is None else whole + HALF
    if "point" not in plain:
        return _whole().get(plain)
    at = plain.index("point")
    digits = [_whole().get((word,), MOST) for word in plain[at + 1 :]]
    whole = _whole().get(plain[:at]) if at else 0
    if whole is None or not digits or max(digits) > 9:
        return None
    return float(f"{whole}.{''.join(map(str, digits))}")


def spoken_value(value: float) -> str:
    """A number from 0 to MOST in words: "two", "one point five", "point five"."""
    if value == int(value):
        return spoken_number(int(value))
    whole, digits = f"{value:.{DECIMALS}f}".rstrip("0").split(".")
    said = " ".join(spoken_number(int(digit)) for digit in digits)
    return f"point {said}" if whole == "0" else f"{spoken_number(int(whole))} point {said}"


def spoken_with_point(value: float) -> str:
    """The same with a point in it always: "two point zero"."""
    said = spoken_value(value)
    return said if "point" in said else f"{said} point zero"


def spoken_amount(value: float, unit: str) -> str:
    """An amount in the words by which it is known: "half a newton", "two millimetres"."""
    one, several = UNITS[unit][:2]
    if value == HALF:
        return f"half a {one}"
    return f"{spoken_value(value)} {one if value == 1.0 else several}"


def canonical(words: Words) -> Words:
    """The same text with each amount in the words by which it is known.

    "pull 0.5 mm more", in words, becomes "pull half a millimetre more". A number that nothing is
    known of stays as it is.
    """
    found: list[str] = []
    end = 0
    for begin, stop, value, unit in _amounts(words):
        found += [*words[end:begin], *spoken_amount(value, unit).split()]
        end = stop
    return (*found, *words[end:])


def with_value(words: Words, value: float) -> Words:
    """The same text with another number, as it would have been heard.

    Args:
        words: With one amount, in any of its words; its unit may be missing.
        value: Said in place of its number.
    """
    for begin, stop, _, unit in _amounts(words):
        heard, (one, several) = words[stop - 1], UNITS[unit][:2]
        if heard in (one, several):
            heard = one if value in (1.0, HALF) else several
        number = "half a" if value == HALF else spoken_value(value)
        return (*words[:begin], *number.split(), heard, *words[stop:])
    for begin in range(len(words)):
        for stop in range(len(words), begin, -1):
            if value_of(words[begin:stop]) is not None:
                return (*words[:begin], *spoken_with_point(value).split(), *words[stop:])
    return words


def in_digits(words: Words) -> str:
    """The same text with the numbers of its amounts in digits: "pull 2 mm more"."""
    found: list[str] = []
    end = 0
    for begin, stop, value, _ in _amounts(words):
        found += [*words[end:begin], f"{value:g}", words[stop - 1]]
        end = stop
    return " ".join((*found, *words[end:]))


def _amounts(words: Words) -> Iterator[tuple[int, int, float, str]]:
    """Beginning, end, value and unit of each amount, from left to right."""
    at = 0
    while at < len(words):
        found = _amount_at(words, at)
        if found is None:
            at += 1
        else:
            yield at, *found
            at = found[0]


def _amount_at(words: Words, at: int) -> tuple[int, float, str] | None:
    """End, value and unit of the amount that begins at a place; None: none begins there."""
    if at and words[at - 1] in _numbers():
        return None  # it would be the end of another number
    for end in range(min(len(words), at + _LONGEST), at, -1):
        value = value_of(words[at:end])
        if value is None:
            continue
        if value == HALF and words[end : end + 1] in (("a",), ("an",)):
            end += 1
        unit = _UNIT_OF.get(words[end]) if end < len(words) else None
        return None if unit is None else (end + 1, value, unit)
    return None
