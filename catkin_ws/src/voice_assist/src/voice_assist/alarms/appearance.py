# SPDX-License-Identifier: BSD-3-Clause
"""How alarms look: colour and flashing show priority, symbol and word show it without colour."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from voice_assist.alarms.types import AlarmText, Kind, Priority

Rgba = tuple[float, float, float, float]  # each from 0 to 1


@dataclass(frozen=True)
class Appearance:
    """How a priority is shown; colours and flashing as is usual for medical alarms."""

    word: str
    colour: str  # in words
    style: str  # for rich
    rgba: Rgba
    flashes: float  # [Hz], half of the time lit; 0: steady


APPEARANCES: Final = {
    Priority.HIGH: Appearance(
        "HIGH", "red, flashing", "bold white on red", (0.90, 0.05, 0.05, 1.0), 2.0
    ),
    Priority.MEDIUM: Appearance(
        "MEDIUM", "yellow, flashing", "bold black on yellow", (0.95, 0.80, 0.00, 1.0), 0.6
    ),
    Priority.LOW: Appearance(
        "LOW", "cyan, steady", "bold black on cyan", (0.00, 0.70, 0.85, 1.0), 0.0
    ),
    Priority.INFORMATION: Appearance("", "green, steady", "green", (0.00, 0.62, 0.35, 1.0), 0.0),
}
SYMBOLS: Final = {
    Kind.STOP: "■",
    Kind.FAULT: "▲",
    Kind.REFUSAL: "✕",
    Kind.NOTICE: "●",
}
MARKS: Final = {Priority.HIGH: "!!!", Priority.MEDIUM: "!!", Priority.LOW: "!"}


def headline(alarm: AlarmText) -> str:
    """Symbol, kind and priority: "▲ FAULT !!! HIGH"."""
    words = [SYMBOLS[alarm.kind], alarm.kind.value.upper(), MARKS.get(alarm.priority, "")]
    return " ".join(word for word in (*words, APPEARANCES[alarm.priority].word) if word)


def line(alarm: AlarmText) -> str:
    """All of an alarm in one line, the same for screen, log and recording."""
    return f"{headline(alarm)}: {alarm.cause} -> {alarm.next_step}"


def is_lit(priority: Priority, time: float) -> bool:
    """Whether a flashing alarm is bright at a time [s]; one that does not flash always is."""
    flashes = APPEARANCES[priority].flashes
    return flashes == 0.0 or (time * flashes) % 1.0 < 0.5
