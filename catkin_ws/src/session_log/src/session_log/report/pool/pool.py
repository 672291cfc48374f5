# SPDX-License-Identifier: BSD-3-Clause
"""Gathers the summaries of one session or of many into the numbers of the tables."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np

from session_log.config import ReportConfig
from session_log.report.bounds import Bounded, proportion
from session_log.report.session.analysis import FAILED
from session_log.report.session.summary import GivenCommand, MomentSummary, SessionSummary
from session_log.report.session.trials import NO_COMMAND, NOT_SAID, NOTHING, OTHER, is_correct

_NUMBER = re.compile(r"-?\d+(\.\d+)?")


@dataclass(frozen=True)
class PooledSession:
    """One session of a pool, as one row of its table."""

    path: Path  # the recording
    page: Path | None  # its own report, if one was written
    name: str
    started: float  # [s] since 1970; zero if nothing was recorded
    duration: float  # [s]
    is_complete: bool
    right: int  # phrases that were taken as they were meant, words that are no command included
    said: int  # phrases whose meaning is known
    commands: int  # taken or given by hand
    refused: int
    action: float  # [s] median time from the end of speech to the action; nan if none
    rcm: float  # [m] largest while moving, by the controller; nan if none
    rcm_joints: float  # [m] the same from joint states
    tension: float  # [N] largest; nan if it was not measured
    margin: float  # [rad] to the nearest joint limit
    late: int  # late cycles of the fast topics
    cycles: int
    words: str  # all that was heard, asked for and answered


@dataclass(frozen=True)
class UnreadSession:
    """A recording that could not be read, and why."""

    path: Path
    reason: str


class Accuracy(NamedTuple):
    """How many phrases were taken as they were meant."""

    right: int
    meant: int
    share: Bounded  # of one


@dataclass
class Latencies:
    """Times after the end of speech, of one command [s]."""

    decision: list[float] = field(default_factory=list)
    action: list[float] = field(default_factory=list)


@dataclass
class InputCounts:
    """What was given by voice, by a node or by hand."""

    given: int = 0
    refused: int = 0
    reactions: list[float] = field(default_factory=list)  # [s] to the action


class Pool:
    """Sums over sessions; the order in which they are added does not matter."""

    def __init__(self, config: ReportConfig) -> None:
        self.config = config
        self.members: list[PooledSession] = []
        self.unread: list[UnreadSession] = []
        self.confusions: Counter[tuple[str, str]] = Counter()  # intended, taken
        self.refusals: Counter[tuple[str, str]] = Counter()  # command, reason
        self.failures: Counter[tuple[str, str]] = Counter()  # the same of calls to devices
        self.outcomes: Counter[str] = Counter()
        self.commits: Counter[str] = Counter()  # of the software that was recorded
        self.early = self.ignored = self.rcm_above = self.rcm_joints_above = 0
        self.knows_intent = False  # whether any session knows what was meant to be said
        self.duration = 0.0  # [s]
        self.rcm = self.rcm_joints = self.tension_error = MomentSummary()
        self.tension = self.tension_with_target = math.nan  # [N] largest
        self.inputs: dict[str, InputCounts] = {}  # by what gave the commands
        self._latencies: dict[str, Latencies] = {}
        self._phrases: dict[str, None] = {}

    def add(self, path: Path, page: Path | None, summary: SessionSummary) -> None:
        """Add one session."""
        self.members.append(_member(path, page, summary))
        self.knows_intent |= summary.knows_intent
        self._phrases |= dict.fromkeys(summary.phrases)
        self.confusions.update((t.intended, t.taken) for t in summary.trials)
        self.commits[summary.commit or "unknown"] += 1
        self.ignored += summary.ignored
        self.duration += summary.duration
        for given in summary.given:
            self._add_given(given)
        self.rcm += summary.rcm
        self.rcm_joints += summary.rcm_joints
        self.rcm_above += summary.rcm_above
        self.rcm_joints_above += summary.rcm_joints_above
        self.tension_error += summary.tension_error
        self.tension = float(np.fmax(self.tension, summary.tension))
        with_target = np.fmax(self.tension_with_target, summary.tension_with_target)
        self.tension_with_target = float(with_target)

    @property
    def commands(self) -> list[str]:
        """Every command: the paper's first, then those compared, meant, taken or given."""
        known = dict.fromkeys(entry.command for entry in self.config.paper.latency)
        seen = {w for pair in self.confusions for w in pair} | set(self._latencies)
        seen -= {NO_COMMAND, NOT_SAID, NOTHING, OTHER}
        return list(known | self._phrases | dict.fromkeys(sorted(seen)))

    def latencies(self, command: str = "") -> Latencies:
        """Times of one command, or of all; sorted."""
        chosen = [v for k, v in self._latencies.items() if command in ("", k)]
        decision = sorted(x for times in chosen for x in times.decision)
        return Latencies(decision, sorted(x for times in chosen for x in times.action))

    def accuracy(self, intended: str = "") -> Accuracy:
        """Phrases taken as they were meant.

        Args:
            intended: A command or NO_COMMAND; empty for all commands together.
        """
        words = [intended] if intended else self.commands
        counts = {pair: n for pair, n in self.confusions.items() if pair[0] in words}
        right = sum(n for (meant, taken), n in counts.items() if is_correct(meant, taken))
        total = sum(counts.values())
        return Accuracy(right, total, proportion(right, total))

    def taken_for_another(self) -> tuple[int, int]:
        """Spoken commands that were taken for another one, of those whose meaning is known."""
        meant = {p: n for p, n in self.confusions.items() if p[0] not in (NO_COMMAND, NOT_SAID)}
        wrong = (n for (said, taken), n in meant.items() if taken not in (said, NOTHING, OTHER))
        return sum(wrong), sum(meant.values())

    def sorted_members(self) -> list[PooledSession]:
        """Members by the time of their recording."""
        return sorted(self.members, key=lambda m: (m.started, str(m.path)))

    def _add_given(self, given: GivenCommand) -> None:
        self.outcomes[given.outcome] += 1
        counts = self.inputs.setdefault(given.given_by, InputCounts())
        counts.given += 1
        counts.refused += given.outcome == "refused"
        if math.isfinite(given.reaction):
            counts.reactions.append(given.reaction)
        if given.outcome == "refused":
            self.refusals[given.command, reason_of(given.message)] += 1
        if given.outcome == FAILED:
            self.failures[given.command, reason_of(given.message)] += 1
        if given.is_spoken:
            self.early += given.is_partial
            times = self._latencies.setdefault(given.command, Latencies())
            times.decision.append(given.decision_latency)
            if math.isfinite(given.action_latency):
                times.action.append(given.action_latency)


def reason_of(message: str) -> str:
    """The kind of a refusal: its words up to the first value or explanation."""
    words = re.split(r"[;:(]", message, maxsplit=1)[0].strip()
    return _NUMBER.sub("…", words) or "no reason given"


def _member(path: Path, page: Path | None, summary: SessionSummary) -> PooledSession:
    actions = [g.action_latency for g in summary.given if math.isfinite(g.action_latency)]
    said = [trial for trial in summary.trials if trial.intended != NOT_SAID]
    return PooledSession(
        path=path,
        page=page,
        name=summary.name,
        started=summary.started,
        duration=summary.duration,
        is_complete=summary.is_complete,
        right=sum(1 for trial in said if trial.is_correct),
        said=len(said),
        commands=len(summary.given),
        refused=sum(1 for given in summary.given if given.outcome == "refused"),
        action=median(actions) if actions else math.nan,
        rcm=_largest(summary.rcm),
        rcm_joints=_largest(summary.rcm_joints),
        tension=summary.tension,
        margin=summary.margin,
        late=sum(loop.late for loop in summary.loops),
        cycles=sum(loop.cycles for loop in summary.loops),
        words=" ".join(dict.fromkeys([*summary.transcripts, *_answers(summary)])),
    )


def _answers(summary: SessionSummary) -> Iterator[str]:
    for given in summary.given:
        yield f"{given.command} {given.outcome} {given.message}"


def _largest(values: MomentSummary) -> float:
    return values.largest if values.count else math.nan
