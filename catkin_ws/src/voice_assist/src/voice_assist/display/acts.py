# SPDX-License-Identifier: BSD-3-Clause
"""What a person may do on the page, and how it is asked for."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

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


class BadRequestError(ValueError):
    """What was asked for is none of the acts; says what is wrong."""


FIELDS: Mapping[str, tuple[str, ...]] = {"microphone": ("name",)}  # of each act, all texts


def read_act(name: str, body: bytes) -> Callable[[Acts], Outcome]:
    """What a guarded act is to do.

    Args:
        name: Of the act, a key of `FIELDS`.
        body: JSON with its fields, no more and no less.

    Raises:
        BadRequestError: It is not.
    """
    given = _fields(name, body)
    return lambda acts: acts.choose_microphone(given["name"])


def _fields(name: str, body: bytes) -> dict[str, str]:
    wanted = FIELDS[name]
    try:
        given = json.loads(body)
    except (ValueError, RecursionError):
        raise BadRequestError("the body is not JSON") from None
    if not isinstance(given, dict) or set(given) != set(wanted):
        raise BadRequestError(f"{name} takes {', '.join(wanted)}, and nothing else")
    return {key: _text(key, given[key]) for key in wanted}


def _text(key: str, value: object) -> str:
    if isinstance(value, str) and 0 < len(value) <= MOST_LETTERS and value.isprintable():
        return value
    raise BadRequestError(f"{key} is printable text of up to {MOST_LETTERS} letters")
