# SPDX-License-Identifier: BSD-3-Clause
"""From a session to figures: one row per command, RCM error, tension, loops."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from session_log.config import ReportConfig
from session_log.report.session.session_data import (
    Intervals,
    RecordedEvent,
    RecordedUtterance,
    SessionData,
    Track,
)

STOP = "stop"
VOICE = "voice"  # by which a command was given
SHUTDOWN = "shutdown"  # reason code of rst_control/ReasonCode
ANSWERS = ("accepted", "refused", "stop_received")
CLOCK_SLACK = 0.02  # [s] an answer may be stamped this much before the decision it answers


@dataclass(frozen=True)
class CommandRow:
    """One command: what was said, what was decided, what the robot did."""

    command: str
    heard: RecordedUtterance | None  # None: given by service or topic, not spoken
    answered: float | None  # [s] accepted, refused or stop received
    outcome: str  # accepted, refused, or "no answer"
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
        return re.sub(r"(_\d+)+$", "", self.caller.lstrip("/")) or "hand"

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


def statistics(values: Iterable[float] | Track) -> Statistics:
    """Summarise numbers; nan among them are left out."""
    x = np.asarray(list(values) if not isinstance(values, np.ndarray) else values, dtype=float)
    x = x[np.isfinite(x)]
    if not len(x):
        return Statistics(0, *[math.nan] * 6)
    median, p95, p99 = np.percentile(x, [50, 95, 99])
    rms = math.sqrt(float(np.mean(x**2)))
    return Statistics(
        len(x), float(x.mean()), rms, float(median), float(p95), float(p99), float(x.max())
    )


def command_rows(data: SessionData, config: ReportConfig) -> list[CommandRow]:
    """Join what was heard with what the controller answered and did, in order of time."""
    answers = sorted(filter(_is_answer, data.events + data.device_calls), key=lambda e: e.time)
    rows = []
    for heard in sorted((h for h in data.heard if h.command), key=lambda h: h.decision):
        mine = _answers_to(heard, answers, data.phrases, config.match_window)
        answers = [a for a in answers if a not in mine]
        rows.append(_row(data, config, heard.command, heard, mine))
    while answers:
        first = answers[0]
        mine = [a for a in answers if a is first or _belongs(first, a)]
        answers = [a for a in answers if a not in mine]
        rows.append(_row(data, config, _command_of(first), None, mine))
    return sorted(rows, key=lambda row: row.time)


def rcm_while_moving(data: SessionData) -> Track:
    """RCM error by the controller while the robot moves [m]; nan while outside. Shape (n,)."""
    return data.controller["rcm_error"][data.controller["moving"] > 0]


def tension_with_target(data: SessionData) -> Track:
    """Tension while there is a target [N]. Shape (n,)."""
    table = data.controller
    return table["tension"][table["target"] > 0]


def tension_error(data: SessionData) -> Track:
    """Distance of the tension from its target at rest with tissue under tension [N]. Shape (n,)."""
    table = data.controller
    at_rest = (table["target"] > 0) & (table["moving"] == 0)
    return np.abs(table["tension"] - table["target"])[at_rest]


def loop_timing(loop: Intervals, late_factor: float) -> LoopTiming:
    """Summarise the cycles of a fast topic."""
    length = np.frombuffer(loop.length, dtype=np.float32).astype(float)
    period = statistics(length)
    late = int(np.count_nonzero(length > late_factor * period.median))
    return LoopTiming(loop.topic, period, late)


def _answers_to(
    heard: RecordedUtterance, answers: list[RecordedEvent], phrases: Collection[str], window: float
) -> list[RecordedEvent]:
    """Answers to the words of a phrase; one that is called otherwise is known by who called."""
    since, until = heard.decision - CLOCK_SLACK, heard.decision + window
    candidates = [a for a in answers if since <= a.time <= until]
    called = (a for a in candidates if a.caller == heard.publisher and a.command not in phrases)
    named = (a for a in candidates if _command_of(a) == heard.command)
    first = next(named, next(called, None) if heard.publisher else None)
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
    return is_stop and abs(other.time - first.time) < 10 * CLOCK_SLACK


def _command_of(event: RecordedEvent) -> str:
    return event.command or (STOP if event.kind == "stop_received" else "")


def _row(
    data: SessionData,
    config: ReportConfig,
    command: str,
    heard: RecordedUtterance | None,
    answers: list[RecordedEvent],
) -> CommandRow:
    if not answers:
        return CommandRow(command, heard, None, "no answer", "", None)
    first = answers[0]
    refused = next((a for a in answers if a.kind == "refused"), None)
    outcome = "refused" if refused else "accepted"
    message = next((a.message for a in answers if a.message), "")
    action = None if refused else _action(data, config, _command_of(first), first.time)
    return CommandRow(command, heard, first.time, outcome, message, action, first.caller)


def _action(data: SessionData, config: ReportConfig, command: str, accepted: float) -> float | None:
    """When the robot began to do it: motion started, braking began, or the state changed.

    Commands without motion of their own act when they are accepted; so do those that only move
    the target of a motion in progress.
    """
    later = (e for e in data.events if 0 <= e.time - accepted <= config.motion_window)
    for event in later:
        if event.kind == "motion_started" and event.command == command:
            return event.time
        if event.kind in ANSWERS and event.time > accepted and _command_of(event) != command:
            break
    moves = any(e.kind == "motion_started" and e.command == command for e in data.events)
    if not moves or _is_moving(data, accepted):
        return accepted
    return None


def _is_moving(data: SessionData, time: float) -> bool:
    return any(s.start <= time < s.end and s.word == "moving" for s in data.states)
