# SPDX-License-Identifier: BSD-3-Clause
"""What a person may do on the page, and how it is asked for."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

STOP = "stop"  # needs no token
MOST_LETTERS = 200  # of a text that is asked for


@dataclass(frozen=True)
class Outcome:
    """What came of an act, in words for the person."""

    is_done: bool
    words: str


class Acts(Protocol):
    """The system, as the page may act on it; each blocks until it is known what came of it."""

    def send_stop(self) -> None:
        """Stop the robot, without waiting for anything."""
        ...

    def stop(self) -> Outcome:
        """Stop it once more, and wait for the controller's answer."""
        ...

    def choose_microphone(self, name: str) -> Outcome:
        """Hear by another microphone."""
        ...

    def answer(self, is_yes: bool) -> Outcome:
        """Answer the question that stands."""
        ...

    def set_grasp(self, column: float, row: float) -> Outcome:
        """Grasp where a person points to, in shares [0, 1] of the picture from its upper left."""
        ...


class BadRequestError(ValueError):
    """What was asked for is none of the acts; says what is wrong."""


FIELDS: Mapping[str, Mapping[str, type]] = {
    "microphone": {"name": str},
    "answer": {"yes": bool},
    "grasp": {"column": float, "row": float},
}


def read_act(name: str, body: bytes) -> Callable[[Acts], Outcome]:
    """What a guarded act is to do.

    Args:
        name: Of the act, a key of `FIELDS`.
        body: JSON with its fields, no more and no less.

    Raises:
        BadRequestError: It is not.
    """
    given = _fields(name, body)
    if name == "microphone":
        return lambda acts: acts.choose_microphone(given["name"])
    if name == "answer":
        return lambda acts: acts.answer(given["yes"])
    return lambda acts: acts.set_grasp(given["column"], given["row"])


def _fields(name: str, body: bytes) -> dict[str, Any]:
    wanted = FIELDS[name]
    try:
        given = json.loads(body)
    except (ValueError, RecursionError):
        raise BadRequestError("the body is not JSON") from None
    if not isinstance(given, dict) or set(given) != set(wanted):
        raise BadRequestError(f"{name} takes {', '.join(wanted)}, and nothing else")
    return {key: _checked(key, given[key], kind) for key, kind in wanted.items()}


def _checked(key: str, value: object, kind: type) -> object:
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        if 0.0 <= value <= 1.0:
            return float(value)
        raise BadRequestError(f"{key} is a number from 0 to 1")
    if not isinstance(value, kind):
        raise BadRequestError(f"{key} is {kind.__name__}")
    if isinstance(value, str) and not (0 < len(value) <= MOST_LETTERS and value.isprintable()):
        raise BadRequestError(f"{key} is printable text of up to {MOST_LETTERS} letters")
    return value
