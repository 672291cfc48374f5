# SPDX-License-Identifier: BSD-3-Clause
"""Declares what a settings key may hold; no key has a default, so the YAML shows every value.

@dataclass(frozen=True, kw_only=True)
class RcmConfig:
    gain: float = number(0.0, 100.0, "1/s")
    trocar: tuple[float, float, float] = number(-2.0, 2.0, "m")
    solver: str = choice("newton", "damped")
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import MISSING, dataclass, field
from typing import Any, Literal

RULE = "typed_config.rule"
Kind = Literal["number", "integer", "flag", "text", "choice", "items"]


@dataclass(frozen=True)
class Rule:
    """What one value may be."""

    kind: Kind
    allowed: str  # in words, for the error
    accepts: Callable[[object], bool]
    convert: Callable[[Any], object] = lambda value: value
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf


def _declare(rule: Rule, default: object = MISSING) -> Any:
    if default is MISSING:
        return field(metadata={RULE: rule})
    return field(default=default, metadata={RULE: rule})


def _is_number(value: object) -> bool:
    if isinstance(value, float):
        return math.isfinite(value)
    return isinstance(value, int) and not isinstance(value, bool)


def number(low: float, high: float, unit: str, *, default: object = MISSING) -> Any:
    """Declare a finite number, or a tuple of them, within [low, high] in the given unit."""

    def accepts(value: object) -> bool:
        return _is_number(value) and low <= value <= high  # type: ignore[operator]

    allowed = f"a number from {low:g} to {high:g} {unit}".rstrip()
    return _declare(Rule("number", allowed, accepts, float, unit, low, high), default)


def integer(low: int, high: int, unit: str = "", *, default: object = MISSING) -> Any:
    """Declare a whole number within [low, high]."""

    def accepts(value: object) -> bool:
        return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high

    allowed = f"a whole number from {low} to {high} {unit}".rstrip()
    return _declare(Rule("integer", allowed, accepts, int, unit, low, high), default)


def flag(*, default: object = MISSING) -> Any:
    """Declare true or false."""
    return _declare(Rule("flag", "true or false", lambda value: isinstance(value, bool)), default)


def text(*, may_be_empty: bool = False, default: object = MISSING) -> Any:
    """Declare a string of printable characters, or a tuple of them."""
    allowed = "printable text" if may_be_empty else "printable text that is not empty"

    def accepts(value: object) -> bool:
        if not isinstance(value, str) or not value.isprintable():
            return False
        return may_be_empty or bool(value.strip())

    return _declare(Rule("text", allowed, accepts), default)


def choice(*values: str, default: object = MISSING) -> Any:
    """Declare one of the given words."""
    rule = Rule(
        "choice", "one of " + ", ".join(v or '""' for v in values), lambda value: value in values
    )
    return _declare(rule, default)


def items(low: int = 0, high: int = 10_000) -> Any:
    """Declare a list of nested settings, `tuple[Inner, ...]`, of a length within [low, high]."""
    return _declare(
        Rule(
            "items",
            f"a list of {low} to {high} entries",
            lambda value: isinstance(value, list) and low <= len(value) <= high,
        )
    )
