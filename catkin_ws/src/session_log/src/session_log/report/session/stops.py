# SPDX-License-Identifier: BSD-3-Clause
"""Everything that stopped the robot, with its cause, from the controller's event log."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from session_log.report.session.session_data import RecordedEvent, Span

KINDS = ("stop_received", "at_rest", "halted")  # of events that report a stop
LATCHED = ("halted", "faulted")  # states of the controller
BRAKING = "stopping"
UNREPORTED = "no cause in the recording"
_SLACK = 0.2  # [s] between an event and the state that belongs to it


@dataclass(frozen=True)
class RecordedStop:
    """One thing that braked the robot, or latched it at rest."""

    time: float  # [s] when it began to brake, or when it was reported
    cause: str
    command: str  # in execution; empty: none
    at_rest: float  # [s] after `time`; nan: it moved nothing, or the recording ends before
    is_latched: bool
    also: tuple[str, ...] = ()  # other words for its cause: it may come by topic and by service


def stops(events: Sequence[RecordedEvent], states: Sequence[Span]) -> list[RecordedStop]:
    """Join the entries of each stop, in order of time.

    Args:
        events: Of the controller's log.
        states: Of the controller, over time.
    """
    found: list[RecordedStop] = []
    for event in sorted((e for e in events if e.kind in KINDS), key=lambda e: e.time):
        last = found[-1] if found else None
        if last is not None and _belongs(last, event):
            found[-1] = _joined(last, event)
        else:
            found.append(_first(event, states))
    reported = [stop.time for stop in found]
    found += [
        RecordedStop(s.start, UNREPORTED, "", math.nan, True) for s in _unreported(states, reported)
    ]
    return sorted(found, key=lambda stop: stop.time)


def _belongs(last: RecordedStop, event: RecordedEvent) -> bool:
    """Whether an entry goes on with the stop before it: each is reported once as it ends."""
    if event.kind == "stop_received":  # later somebody stopped once more
        return event.time - last.time < _SLACK  # at rest the latch is reported between the two
    if event.kind == "at_rest" and math.isfinite(last.at_rest):  # a robot comes to rest only once
        return False
    return event.message in (last.cause, *last.also) and not last.is_latched


def _first(event: RecordedEvent, states: Sequence[Span]) -> RecordedStop:
    is_rest, is_latch = event.kind == "at_rest", event.kind == "halted"
    begin = _braking_since(event.time, states) if is_rest else event.time
    at_rest = event.time - begin if is_rest else math.nan
    command = "" if event.kind == "stop_received" else event.command
    return RecordedStop(begin, event.message, command, at_rest, is_latch)


def _joined(last: RecordedStop, event: RecordedEvent) -> RecordedStop:
    if event.kind == "stop_received":
        return replace(last, also=(*last.also, event.message))
    if event.kind == "at_rest":
        return replace(last, command=event.command, at_rest=event.time - last.time)
    return replace(last, command=last.command or event.command, is_latched=True)


def _braking_since(time: float, states: Sequence[Span]) -> float:
    """When the braking began that ended at a time [s]; that time where it is not known."""
    spans = [s for s in states if s.word == BRAKING and s.start <= time <= s.end + _SLACK]
    return spans[-1].start if spans else time


def _unreported(states: Sequence[Span], reported: Sequence[float]) -> list[Span]:
    """Latches before which no stop was reported since the robot was last free."""
    missing: list[Span] = []
    free = -math.inf
    for span in states:
        if span.word not in (*LATCHED, BRAKING):
            free = span.end
        elif span.word in LATCHED and not any(free - _SLACK <= t <= span.end for t in reported):
            missing.append(span)
    return missing
