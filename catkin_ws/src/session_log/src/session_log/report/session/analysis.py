# SPDX-License-Identifier: BSD-3-Clause
"""From a session to figures: one row per command, RCM error, loops."""

from __future__ import annotations

import math
import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from session_log.config import ReportConfig
from session_log.report.session.controller_words import STOP
from session_log.report.session.session_data import (
    DEVICES,
    Intervals,
    RecordedEvent,
    RecordedUtterance,
    SessionData,
    Track,
)

VOICE = "voice"  # by which a command was given
SHUTDOWN = "shutdown"  # reason code of rst_control/ReasonCode
FAILED = "failed"  # outcome of a call to a device; the controller refused nothing
ANSWERS = ("accepted", "refused", "stop_received")
CLOCK_SLACK = 0.02  # [s] an answer may be stamped this much before the decision it answers
SAME_STOP = 10 * CLOCK_SLACK  # [s] within which one stop comes by service and by topic


@dataclass(frozen=True)
class CommandRow:
    """One command: what was said, what was decided, what the robot did."""

    command: str
    heard: RecordedUtterance | None  # None: given by service or topic, not spoken
    answered: float | None  # [s] accepted, refused or stop received
    outcome: str  # accepted, refused by the controller, failed at a device, or "no answer"
    message: str  # the controller's words
    action: float | None  # [s] the robot began to do it
    caller: str = ""  # node that asked; older recordings have none

    @property
    def time(self) -> float:
        """When it was decided, or answered if it was not spoken [s].

        A spotter sends a stop by itself, before the utterance is decided.
        """
        times = (self.heard.decision if self.heard else None, self.answered)
        return min((time for time in times if time is not None), default=0.0)

    @property
    def given_by(self) -> str:
        """Voice, or the node that asked without the numbers of its run; a hand where unknown."""
        if self.heard:
            return VOICE
        name = re.sub(r"(_\d+)+$", "", self.caller.lstrip("/"))
        return f"/{name}" if name == VOICE else name or "hand"

    @property
    def reaction(self) -> float:
        """From the end of speech, or else the answer, to the robot's action [s]; nan if none."""
        if self.heard or self.action is None or self.answered is None:
            return self.action_latency
        return self.action - self.answered

    @property
    def decision_latency(self) -> float:
        """From the end of speech to the decision [s]; nan if not spoken."""
        return self.time - self.heard.speech_end if self.heard else math.nan

    @property
    def action_latency(self) -> float:
        """From the end of speech to the robot's action [s]; nan if there is none."""
        if self.heard is None or self.action is None:
            return math.nan
        return self.action - self.heard.speech_end


@dataclass(frozen=True)
class Statistics:
    """Of a set of numbers, in their unit; nan where there are none."""

    count: int
    mean: float
    rms: float
    median: float
    p95: float
    p99: float
    largest: float


@dataclass(frozen=True)
class LoopTiming:
    """How evenly a fast topic was published."""

    topic: str
    period: Statistics  # [s]
    late: int  # cycles longer than late_factor medians


def statistics(values: Track) -> Statistics:
    """Summarise the finite ones of numbers, shape (n,)."""
    x = values[np.isfinite(values)]
    if not len(x):
        return Statistics(0, *[math.nan] * 6)
    median, p95, p99 = np.percentile(x, [50, 95, 99])
    rms = math.sqrt(float(np.mean(x**2)))
    return Statistics(
        len(x), float(x.mean()), rms, float(median), float(p95), float(p99), float(x.max())
    )


def command_rows(data: SessionData, config: ReportConfig) -> list[CommandRow]:
    """Join what was heard with what the controller answered and did, in order of time."""
    answers = _ByTime(filter(_is_answer, data.events + data.device_calls))
    by_device = _device_answers(data)
    log, taken, rows = _ControllerLog(data, config), set(by_device.values()), []
    for heard in sorted((h for h in data.heard if h.command), key=lambda h: h.decision):
        since = min(heard.speech_start, heard.decision - CLOCK_SLACK)
        near = answers.between(since, heard.decision + config.match_window)
        if heard in by_device:
            mine = [by_device[heard]]
        else:
            mine = _answers_to(heard, [a for a in near if a not in taken], data)
        taken.update(mine)
        rows.append(_row(log, heard.command, heard, mine))
    for first in answers.events:
        if first not in taken:
            taken.add(first)
            near = answers.between(first.time, first.time + SAME_STOP)
            mine = [first, *(a for a in near if a not in taken and _belongs(first, a))]
            taken.update(mine)
            rows.append(_row(log, _command_of(first), None, mine))
    return sorted(rows, key=lambda row: row.time)


def rcm_while_moving(data: SessionData) -> Track:
    """RCM error by the controller while the robot moves [m]; nan while outside. Shape (n,)."""
    return data.controller["rcm_error"][data.controller["moving"] > 0]


def loop_timing(loop: Intervals, late_factor: float) -> LoopTiming:
    """Summarise the cycles of a fast topic."""
    length = np.frombuffer(loop.length, dtype=np.float32).astype(float)
    period = statistics(length)
    late = int(np.count_nonzero(length > late_factor * period.median))
    return LoopTiming(loop.topic, period, late)


class _ByTime:
    """Events in order of time."""

    def __init__(self, events: Iterable[RecordedEvent]) -> None:
        self.events = sorted(events, key=lambda e: e.time)
        self._times = [e.time for e in self.events]

    def between(self, first: float, last: float) -> list[RecordedEvent]:
        """Those from one time to another [s], both included."""
        return self.events[bisect_left(self._times, first) : bisect_right(self._times, last)]


class _ControllerLog:
    """What the robot did after a command was accepted."""

    def __init__(self, data: SessionData, config: ReportConfig) -> None:
        self._events, self._window = _ByTime(data.events), config.motion_window
        self._moved = {e.command for e in data.events if e.kind == "motion_started"}
        self._moving = sorted((s.start, s.end) for s in data.states if s.word == "moving")

    def action(self, command: str, accepted: float) -> float | None:
        """When the robot began to do it: motion started, braking began, or the state changed.

        Commands without motion of their own act when they are accepted; so do those that only
        move the target of a motion in progress.
        """
        if command not in self._moved:
            return accepted
        for event in self._events.between(accepted, accepted + self._window):
            if event.kind == "motion_started" and event.command == command:
                return event.time
            if event.kind in ANSWERS and event.time > accepted and _command_of(event) != command:
                break
        return accepted if self._is_moving(accepted) else None

    def _is_moving(self, time: float) -> bool:
        before = bisect_right(self._moving, (time, math.inf))
        return before > 0 and time < self._moving[before - 1][1]


def _device_answers(data: SessionData) -> dict[RecordedUtterance, RecordedEvent]:
    """What devices answered to phrases, however long it took; nothing where none came.

    An answer is of the last words before it that have none yet. Calls of one phrase are made one
    after the other, so their answers have the order of the words.
    """
    found: dict[RecordedUtterance, RecordedEvent] = {}
    for phrase in {call.command for call in data.device_calls}:
        left = _ByTime(c for c in data.device_calls if c.command == phrase).events
        words = [h for h in data.heard if h.command == phrase]
        said, given = [], []
        for heard in sorted(words, key=lambda h: h.decision, reverse=True):
            since = heard.decision - CLOCK_SLACK
            if call := next((c for c in left if c.time >= since), None):
                left.remove(call)
                said.append(heard)
                given.append(call)
        given.sort(key=lambda c: c.time, reverse=True)
        found |= zip(said, given, strict=True)
    return found


def _answers_to(
    heard: RecordedUtterance, answers: list[RecordedEvent], data: SessionData
) -> list[RecordedEvent]:
    """Answers of the controller to the words of a phrase.

    What it calls the phrase stands in the recorded settings, but for phrases with an amount. Where
    it does not, an answer in other words is known by who called.

    Args:
        heard: The phrase.
        answers: From its begin until they can no longer be about it, in order of time.
        data: Of the session, with every command that the recogniser knows.
    """
    since = heard.decision - CLOCK_SLACK
    candidates = [a for a in answers if a.time >= since]
    known = {*data.phrases, *data.called.values()}
    called = (a for a in candidates if a.caller == heard.publisher and a.command not in known)
    word = data.called.get(heard.command, heard.command)
    named = (a for a in candidates if _command_of(a) == word)
    is_unknown = heard.publisher and heard.command not in data.called
    first = next(named, next(called, None) if is_unknown else None)
    if first is None:
        return []
    sooner = [
        a for a in answers if heard.speech_start <= a.time < since and _is_same_stop(first, a)
    ]
    return sooner + [a for a in candidates if a is first or _belongs(first, a)]


def _is_same_stop(first: RecordedEvent, sooner: RecordedEvent) -> bool:
    """Whether a node stopped the robot in the same word, before it had decided on it all."""
    is_stop = _command_of(first) == STOP and sooner.kind == "stop_received"
    return is_stop and sooner.caller == first.caller != ""


def _is_answer(event: RecordedEvent) -> bool:
    """An end of the program, such as by Ctrl-C, is no command that somebody gave."""
    return event.kind in ANSWERS and event.reason_code != SHUTDOWN


def _belongs(first: RecordedEvent, other: RecordedEvent) -> bool:
    """Whether two answers are about the same stop: it may come by service and by topic."""
    is_stop = _command_of(first) == _command_of(other) == STOP
    return is_stop and abs(other.time - first.time) < SAME_STOP


def _command_of(event: RecordedEvent) -> str:
    return event.command or (STOP if event.kind == "stop_received" else "")


def _row(
    log: _ControllerLog,
    command: str,
    heard: RecordedUtterance | None,
    answers: list[RecordedEvent],
) -> CommandRow:
    if not answers:
        return CommandRow(command, heard, None, "no answer", "", None)
    first = answers[0]
    outcome = "accepted"
    if refused := next((a for a in answers if a.kind == "refused"), None):
        outcome = FAILED if refused.caller == DEVICES else "refused"
    message = next((a.message for a in answers if a.message), "")
    action = None if refused else log.action(_command_of(first), first.time)
    return CommandRow(command, heard, first.time, outcome, message, action, first.caller)
