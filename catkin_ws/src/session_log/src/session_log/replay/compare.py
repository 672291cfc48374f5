# SPDX-License-Identifier: BSD-3-Clause
"""What was decided then and what is decided now, one by one.

Compared are transcript, command, reason, WER, confidence, nearest command, mode, who decided,
whether that was before the end, and start and end of speech. Not compared is when it was decided:
that depends on the machine.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from math import isnan

from session_log.replay.config import ReplayConfig
from session_log.replay.pipeline_plugin import Decided
from session_log.replay.recorded_voice import RecordedDecision

MISSING, EXTRA, ORDER = "missing", "extra", "order"

Pair = tuple[RecordedDecision | None, Decided | None]


@dataclass(frozen=True)
class Difference:
    """One utterance that came out differently."""

    number: int  # of the recorded utterance, from 1; of an extra one: of that before it
    kinds: tuple[str, ...]  # missing, extra, order, or the fields that differ
    recorded: RecordedDecision | None
    now: Decided | None
    excuse: str = ""  # why it does not count: what of the recording is lost

    @property
    def decision(self) -> float:
        """When it was decided, then or (of an extra one) now [s] of the clock."""
        either = self.recorded or self.now
        return either.decision if either is not None else 0.0


def compare(
    recorded: Sequence[RecordedDecision], now: Sequence[Decided], config: ReplayConfig
) -> list[Difference]:
    """All differences, in the order of the recording.

    Args:
        recorded: As decided then, in that order.
        now: As decided now, in that order.
        config: What counts as the same.
    """
    differences, number = [], 0
    for then, again in _align(recorded, now, config):
        number += then is not None
        if then is None or again is None:
            kinds: tuple[str, ...] = (EXTRA if then is None else MISSING,)
        else:
            kinds = tuple(_fields(then, again, config))
        if kinds:
            differences.append(Difference(number, kinds, then, again))
    return _join_moved(differences, config)


def _fields(then: Decided, now: Decided, config: ReplayConfig) -> Iterator[str]:
    """Names of what differs between two views of one utterance."""
    if then.transcript != now.transcript:
        yield "transcript"
    if then.command != now.command:
        yield "command"
    elif _without_numbers(then.reason) != _without_numbers(now.reason):
        yield "reason"
    if not _is_same_wer(then.wer, now.wer, config.wer_tolerance):
        yield "WER"
    if not _is_close(then.confidence, now.confidence, config.confidence_tolerance):
        yield "confidence"
    for name in ("nearest_command", "mode", "decided_by", "is_partial"):
        if getattr(then, name) != getattr(now, name):
            yield name
    if not _is_close(then.speech_start, now.speech_start, config.time_tolerance):
        yield "start of speech"
    if not _is_close(then.speech_end, now.speech_end, config.time_tolerance):
        yield "end of speech"


def _is_same_wer(then: Mapping[str, float], now: Mapping[str, float], tolerance: float) -> bool:
    return then.keys() == now.keys() and all(
        _is_close(value, now[phrase], tolerance) for phrase, value in then.items()
    )


def _is_close(then: float, now: float, tolerance: float) -> bool:
    """Whether two numbers count as the same; what is no number is like nothing but its like."""
    return abs(then - now) <= tolerance or (isnan(then) and isnan(now))


def _without_numbers(reason: str) -> str:
    """A confidence in words is compared as a number elsewhere."""
    return re.sub(r"\d+(\.\d+)?", "#", reason)


def _align(
    recorded: Sequence[RecordedDecision], now: Sequence[Decided], config: ReplayConfig
) -> Iterator[Pair]:
    """Pair what is the same; between those, what ended at about the same time."""
    keys = [[_key(entry) for entry in entries] for entries in (recorded, now)]
    matcher = SequenceMatcher(None, keys[0], keys[1], autojunk=False)
    for what, i, i_end, j, j_end in matcher.get_opcodes():
        if what == "equal":
            yield from zip(recorded[i:i_end], now[j:j_end], strict=True)
        else:
            yield from _align_by_time(recorded[i:i_end], now[j:j_end], config.match_window)


def _key(entry: Decided) -> tuple[str, str, float]:
    return entry.transcript, entry.command, round(entry.speech_end, 2)


def _align_by_time(
    recorded: Sequence[RecordedDecision], now: Sequence[Decided], window: float
) -> Iterator[Pair]:
    i = j = 0
    while i < len(recorded) and j < len(now):
        apart = now[j].speech_end - recorded[i].speech_end
        if abs(apart) <= window:
            if _is_nearer(recorded[i], now, j):
                yield None, now[j]
                j += 1
            elif _is_nearer(now[j], recorded, i):
                yield recorded[i], None
                i += 1
            else:
                yield recorded[i], now[j]
                i, j = i + 1, j + 1
        elif apart > 0:
            yield recorded[i], None
            i += 1
        else:
            yield None, now[j]
            j += 1
    yield from ((entry, None) for entry in recorded[i:])
    yield from ((None, entry) for entry in now[j:])


def _is_nearer(entry: Decided, others: Sequence[Decided], index: int) -> bool:
    """Whether the next of the others ended nearer to an entry than the one at the index."""
    if index + 1 >= len(others):
        return False
    this, following = others[index], others[index + 1]
    return abs(following.speech_end - entry.speech_end) < abs(this.speech_end - entry.speech_end)


def _join_moved(differences: list[Difference], config: ReplayConfig) -> list[Difference]:
    """One missing and one extra of the same content are one that came in another order."""
    extras = [entry for entry in differences if entry.kinds == (EXTRA,)]
    joined, gone = [], set()
    for entry in differences:
        moved = next((e for e in extras if id(e) not in gone and _moved(entry, e, config)), None)
        if moved is not None:
            gone.add(id(moved))
            entry = replace(entry, kinds=(ORDER,), now=moved.now)
        joined.append(entry)
    return [entry for entry in joined if id(entry) not in gone]


def _moved(missing: Difference, extra: Difference, config: ReplayConfig) -> bool:
    then, now = missing.recorded, extra.now
    if missing.kinds != (MISSING,) or then is None or now is None:
        return False
    is_same = (then.transcript, then.command) == (now.transcript, now.command)
    return is_same and abs(then.speech_end - now.speech_end) <= config.match_window
