# SPDX-License-Identifier: BSD-3-Clause
"""Wrong values for a key, made from what it holds and from what it may hold."""

from __future__ import annotations

import datetime
import math
from collections.abc import Iterator

from tests.unit.typed_config.settings_files import GONE, Leaf

HUGE = 10**400  # is a number to YAML, and none to floating point
DAY = datetime.date(2026, 11, 21)  # what YAML makes of 2026-11-21

# The other unit in which people write what a key holds in SI, and how much larger its number is.
OTHER_UNITS = {
    "m": ((1e3, "mm"),),
    "m/s": ((1e3, "mm/s"),),
    "m/s^2": ((1e3, "mm/s^2"),),
    "m/s^3": ((1e3, "mm/s^3"),),
    "rad": ((57.3, "deg"),),
    "rad/s": ((57.3, "deg/s"),),
    "rad/s^2": ((57.3, "deg/s^2"),),
    "rad/s^3": ((57.3, "deg/s^3"),),
    "s": ((1e3, "ms"),),
    "N": ((1e3, "mN"), (102.0, "gf")),
    "N/m": ((1e-3, "N/mm"), (1e3, "mN/m")),
    "N m": ((1e3, "N mm"),),
    "N m/rad": ((1.0 / 57.3, "N m/deg"),),
    "N m s/rad": ((1e3, "N mm s/rad"),),
    "kg": ((1e3, "g"),),
    "kg m^2": ((1e6, "kg mm^2"),),
    "kg/m^2": ((1e3, "g/m^2"),),
    "Hz": ((1e-3, "kHz"),),
    "1/s": ((1e-3, "1/ms"),),
    "(m/rad)^8": ((1e24, "(mm/rad)^8"),),
    "WER": ((1e2, "percent"),),
    "B": ((1e-6, "MB"), (1e-3, "kB")),
}
NO_OTHER_UNIT = {  # units that people write in one way
    "": "a count, ratio, direction or colour",
    "dB": "everybody's unit of it",
    "cent": "everybody's unit of it",
    "dB/s": "everybody's unit of it",
    "mm or N": "its own: the key `unit` beside it says which",
    "nat": "its own: odds have no physical bound",
    "1/nat": "its own: odds have no physical bound",
    "times real time": "a ratio",
    "frames": "a count",
    "partials": "a count",
    "transcripts": "a count",
    "threads": "a count",
    "messages": "a count",
    "pixels": "a count",
    "dpi": "everybody's unit of it",
    "quarter turns": "whole, from -3 to 3: no angle but 0 to 3 is one",
    "words/min": "everybody's unit of it",
}
WRONG_FOR_ALL = {
    "null": None,
    "a mapping": {"value": 1},
    "a list in a list": [[1.0]],
    "a day": DAY,
    "bytes": b"\0",
}


def wrong_values(leaf: Leaf, value: object) -> Iterator[tuple[str, object]]:
    """Kind of mistake, and what then stands in the file."""
    if not leaf.is_entry and not leaf.has_free_name:
        yield "missing", GONE
    if not leaf.is_first:  # its like in the first mapping of the list is tried in every way
        yield ("NaN", math.nan) if leaf.is_entry else ("null", None)
        return
    yield from WRONG_FOR_ALL.items()
    if leaf.is_list:
        yield from _lists(leaf, value)
        return
    yield "a list", [value]
    if leaf.rule.kind in ("number", "integer"):
        yield from _numbers(leaf, value)
    elif leaf.rule.kind == "flag":
        yield from (("0 for false", 0), ("1 for true", 1), ("a number", 2.0), ("text", "true"))
    else:
        yield from _words(leaf, value)


def _numbers(leaf: Leaf, value: float) -> Iterator[tuple[str, object]]:
    yield "NaN", math.nan
    yield from (("infinity", math.inf), ("-infinity", -math.inf))
    yield from (("true for 1", True), ("false for 0", False))
    yield from (("text", "wrong"), ("number in quotes", str(value)), ("empty text", ""))
    yield from (("number with unit", f"{value} {leaf.rule.unit or 'x'}"), ("huge", HUGE))
    yield from (("-huge", -HUGE),)
    low, high = leaf.rule.low, leaf.rule.high
    if leaf.rule.kind == "integer":
        yield from (("a fraction", value + 0.5), ("a float", float(value)))
        yield from (("below its range", low - 1), ("above its range", high + 1))
    else:
        yield "below its range", math.nextafter(low, -math.inf)
        yield "above its range", math.nextafter(high, math.inf)
    if (value > 0 and low >= 0) or (value < 0 and high <= 0):
        yield "wrong sign", -value


def _words(leaf: Leaf, value: str) -> Iterator[tuple[str, object]]:
    yield from (("a number", 3), ("a fraction", 2.5), ("NaN", math.nan))
    yield from (("true", True), ("false", False), ("a list without entry", []))
    yield "a character that cannot be seen", f"{value}\0"
    if not leaf.rule.accepts(""):
        yield from (("empty text", ""), ("blank text", "  "))
    if leaf.rule.kind == "choice":
        yield from (("no such word", "no such word"), ("capitals", f"{value}X".upper()))


def _lists(leaf: Leaf, value: list) -> Iterator[tuple[str, object]]:
    yield from (("a number for a list", 1.0), ("text for a list", "wrong"), ("true", True))
    if leaf.size is not None:
        yield from (("one too few", value[1:]), ("one too many", [*value, value[-1]]))
        yield "no entry", []
    yield from (
        ("null among them", [*value[1:], None]),
        ("mapping of them", dict(enumerate(value))),
    )
    yield "in one more list", [value]


def in_other_units(leaf: Leaf, value: object) -> Iterator[tuple[str, object]]:
    """The value as people write it who think in another unit; nothing where it is all zero."""
    numbers = value if leaf.is_list else [value]
    if leaf.rule.kind not in ("number", "integer") or not any(numbers):
        return
    for factor, unit in OTHER_UNITS.get(leaf.rule.unit, ()):
        scaled = [number * factor for number in numbers]
        if leaf.rule.kind == "integer":
            scaled = [round(number) for number in scaled]
        yield unit, scaled if leaf.is_list else scaled[0]
    if leaf.rule.unit == "" and leaf.rule.high == 1.0 and leaf.rule.low == 0.0:
        percent = [100.0 * number for number in numbers]
        yield "percent", percent if leaf.is_list else percent[0]
