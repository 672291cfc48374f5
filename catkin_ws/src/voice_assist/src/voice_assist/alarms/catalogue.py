# SPDX-License-Identifier: BSD-3-Clause
"""All alarms as tables, for the command line and for docs/reference/alarms.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from voice_assist.alarms.appearance import APPEARANCES, headline
from voice_assist.alarms.causes import GIVE_UPS, LATCHES, PARTS, REFUSALS, UNHEARD, Advice
from voice_assist.alarms.earcons import PATTERNS
from voice_assist.alarms.types import AlarmText, Earcon, Kind
from voice_assist.answers.sentences import why


@dataclass(frozen=True)
class Entry:
    """One sound with what it means."""

    earcon: Earcon
    example: AlarmText
    meaning: str


def _entry(earcon: Earcon, kind: Kind, meaning: str, cause: str, next_step: str) -> Entry:
    return Entry(earcon, AlarmText(kind, PATTERNS[earcon].priority, cause, next_step), meaning)


ENTRIES: Final = (
    _entry(
        Earcon.FAULT_HIGH,
        Kind.FAULT,
        "something failed while tissue is held or the robot moved; it brakes and holds",
        "tension 2.50 N, allowed 2.40 N",
        'Say "hey robot", then "release".',
    ),
    _entry(
        Earcon.FAULT_MEDIUM,
        Kind.FAULT,
        "something failed at rest, with nothing held; or a motion was given up with tissue held",
        "robot not connected",
        'Check the robot\'s power, cable and driver, then say "hey robot".',
    ),
    _entry(
        Earcon.FAULT_LOW,
        Kind.FAULT,
        "something failed that stops nothing now: the recording at rest, the spotter",
        "recording: not recorded: recorder silent for 1.2 s, allowed 1.0 s",
        "Start the recorder before the next motion.",
    ),
    _entry(
        Earcon.STOP,
        Kind.STOP,
        "a person or a program stopped the robot; it brakes, holds and is latched",
        "stopped by voice",
        'Say "hey robot" when it is safe to go on.',
    ),
    _entry(
        Earcon.REFUSAL,
        Kind.REFUSAL,
        "a command is not carried out; nothing moves that did not move before",
        'tense: in standby; say "hey robot" first',
        'Say "hey robot" first.',
    ),
    _entry(
        Earcon.QUESTION,
        Kind.REFUSAL,
        'a motion was nearly sure; it is done after a "yes", and dropped by all else',
        'pull more: nearly sure; say "yes" within 3 s: confidence 0.71, allowed: at least 0.80',
        'Say "yes" if it is what you said.',
    ),
    _entry(
        Earcon.ACCEPTED,
        Kind.NOTICE,
        "a command was accepted",
        "pull more: pulls to 0.90 N",
        'Say "stop" to stop it.',
    ),
    _entry(
        Earcon.ARMED,
        Kind.NOTICE,
        '"hey robot" was accepted; commands count, and any latch is cleared',
        "hey robot: ready",
        "Say a command.",
    ),
    _entry(
        Earcon.STANDBY,
        Kind.NOTICE,
        '"terminate" was accepted; only "hey robot" and "stop" count',
        "terminate: finishes braking, holds and stands by",
        'Say "hey robot" to go on.',
    ),
)


def sounds_of(earcon: Earcon) -> str:
    """A sound in words: "3 pulses, 523 440 349 Hz, 0.90 s"."""
    pattern = PATTERNS[earcon]
    count = len(pattern.starts)
    pulses = f"{'soft ' if pattern.is_soft else ''}{'pulse' if count == 1 else 'pulses'}"
    shown = pattern.pitches[: count // 2] if count == 10 else pattern.pitches
    pitches = " ".join(f"{pitch:.0f}" for pitch in shown)
    twice = ", twice" if count == 10 else ""
    return f"{count} {pulses}, {pitches} Hz{twice}, {pattern.duration:.2f} s"


def markdown() -> str:
    """The tables of docs/reference/alarms.md."""
    rows = [
        (
            f"`{e.earcon.value}`",
            headline(e.example),
            APPEARANCES[e.example.priority].colour,
            sounds_of(e.earcon),
            e.meaning,
        )
        for e in ENTRIES
    ]
    parts = [_table(("name", "line", "colour", "sound", "means"), rows)]
    for title, causes in (
        ("What brakes and latches", LATCHES),
        ("What gives a motion up", GIVE_UPS),
        ("What fails in a part", PARTS),
        ("What the controller refuses", REFUSALS),
        ("What the voice refuses", UNHEARD),
    ):
        parts += [f"### {title}", _causes(causes)]
    return "\n\n".join(parts)


def _causes(causes: Mapping[str, Advice]) -> str:
    rows = [(f"`{code}`", a.kind.value, a.next_step, why(code)) for code, a in causes.items()]
    return _table(("reason code", "kind", "what to do next", "said aloud"), rows)


def _table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
