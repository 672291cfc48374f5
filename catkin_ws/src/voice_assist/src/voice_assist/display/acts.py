# SPDX-License-Identifier: BSD-3-Clause
"""What a person may do on the page, and how it is asked for."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, Protocol, TypeGuard

STOP = "stop"  # needs no token
MOST_LETTERS = 200  # of a text that is asked for
MOST_SHOWN = 40  # letters of what was given wrongly


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

    def answer(self, command: str, is_yes: bool) -> Outcome:
        """Answer what the voice node asked: do this command, or drop it."""
        ...

    def set_grasp_point(self, x: float, y: float, stamp: float) -> Outcome:
        """Take the tissue at a place of the picture of that stamp: shares of width and height."""
        ...


class BadRequestError(ValueError):
    """What was asked for is none of the acts; says what is wrong."""


@dataclass(frozen=True)
class _Form:
    """The fields of one act, each with what reads it, and what it does with them."""

    fields: Mapping[str, Callable[[str, object], object]]
    call: Callable[..., Outcome]  # with the system, and the fields in their order


def read_act(name: str, body: bytes) -> Callable[[Acts], Outcome]:
    """What a guarded act is to do.

    Args:
        name: Of the act, a key of `FORMS`.
        body: JSON with its fields, no more and no less.

    Raises:
        BadRequestError: It is not.
    """
    form = FORMS[name]
    try:
        given = json.loads(body)
    except (ValueError, RecursionError):
        raise BadRequestError(f"the body is {body[:MOST_SHOWN]!r}, allowed: JSON") from None
    if not isinstance(given, dict) or set(given) != set(form.fields):
        found = ", ".join(given) if isinstance(given, dict) else _shown(given)
        allowed = f"{', '.join(form.fields)}, and nothing else"
        raise BadRequestError(f"{name} has {found[:MOST_SHOWN] or 'nothing'}, allowed: {allowed}")
    values = [read(key, given[key]) for key, read in form.fields.items()]
    return lambda acts: form.call(acts, *values)


def _yes(key: str, value: object) -> bool:
    if isinstance(value, bool):
        return value
    raise _refused(key, value, "true or false")


def _share(key: str, value: object) -> float:
    if _is_number(value) and 0.0 <= value < 1.0:
        return float(value)
    raise _refused(key, value, "a share of the picture, from 0 up to below 1")


def _stamp(key: str, value: object) -> float:
    if _is_number(value) and 0.0 <= value < math.inf:
        return float(value)
    raise _refused(key, value, "when the picture was taken, in seconds from 0 on")


def _is_number(value: object) -> TypeGuard[int | float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _text(key: str, value: object) -> str:
    if isinstance(value, str) and 0 < len(value) <= MOST_LETTERS and value.isprintable():
        return value
    raise _refused(key, value, f"printable text of 1 to {MOST_LETTERS} letters")


def _refused(key: str, value: object, allowed: str) -> BadRequestError:
    return BadRequestError(f"{key} is {_shown(value)}, allowed: {allowed}")


def _shown(value: object) -> str:
    """What was given, in short."""
    if isinstance(value, list | dict):
        return f"a {type(value).__name__}"
    return f"{value!r:.{MOST_SHOWN}}"


FORMS: Final[Mapping[str, _Form]] = {
    "microphone": _Form({"name": _text}, lambda acts, name: acts.choose_microphone(name)),
    "answer": _Form(
        {"command": _text, "yes": _yes}, lambda acts, command, yes: acts.answer(command, yes)
    ),
    "grasp": _Form(
        {"x": _share, "y": _share, "stamp": _stamp},
        lambda acts, x, y, stamp: acts.set_grasp_point(x, y, stamp),
    ),
}
