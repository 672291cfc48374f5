# SPDX-License-Identifier: BSD-3-Clause
"""A session reduced to what a table over many sessions needs; a few kB, whatever its length."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from session_log.config import ReportConfig
from session_log.report.session.analysis import (
    VOICE,
    CommandRow,
    loop_timing,
    rcm_while_moving,
    statistics,
)
from session_log.report.session.joint_margins import smallest_margin
from session_log.report.session.namespaces import namespaces_of
from session_log.report.session.session_data import SessionData, Track
from session_log.report.session.shaft import JointRcm
from session_log.report.session.tension import (
    measured_tension,
    tension_error,
    tension_with_target,
)
from session_log.report.session.trials import PhraseTrial, trials


@dataclass(frozen=True)
class MomentSummary:
    """Of a set of numbers, in their unit; those of two sets can be joined exactly."""

    count: int = 0
    squares: float = 0.0
    largest: float = -math.inf

    @property
    def rms(self) -> float:
        """Root of the mean square; nan of none."""
        return math.sqrt(self.squares / self.count) if self.count else math.nan

    def __add__(self, other: MomentSummary) -> MomentSummary:
        return MomentSummary(
            self.count + other.count,
            self.squares + other.squares,
            max(self.largest, other.largest),
        )


@dataclass(frozen=True)
class GivenCommand:
    """One command that was taken or given by hand."""

    command: str
    decision_latency: float  # [s] after the end of speech; nan if not spoken
    reaction: float  # [s] from the end of speech, or the answer, to the action; nan: none
    outcome: str  # as of CommandRow
    message: str
    is_partial: bool
    given_by: str = VOICE  # or a node, or "hand"

    @property
    def is_spoken(self) -> bool:
        """It was heard."""
        return self.given_by == VOICE

    @property
    def action_latency(self) -> float:
        """From the end of speech to the action [s]; nan if not spoken, or there was none."""
        return self.reaction if self.is_spoken else math.nan


@dataclass(frozen=True)
class LoopTimes:
    """How evenly a fast topic was published."""

    topic: str
    cycles: int
    late: int


@dataclass(frozen=True)
class SessionSummary:
    """One session in numbers."""

    name: str
    started: float  # [s] since 1970; zero if nothing was recorded
    duration: float  # [s]
    is_complete: bool  # nothing is known to be lacking in the recording or in these figures
    commit: str
    phrases: tuple[str, ...]
    knows_intent: bool  # whether it was recorded what was meant to be said
    trials: tuple[PhraseTrial, ...]
    given: tuple[GivenCommand, ...]
    ignored: int  # utterances that were no command
    rcm: MomentSummary  # [m] by the controller, while moving
    rcm_joints: MomentSummary  # [m] from joint states, while moving
    rcm_above: int  # samples of `rcm` above the limit
    rcm_joints_above: int
    tension: float  # [N] largest; nan if it was not measured
    tension_with_target: float  # [N] largest while a target was set; nan if there was none
    tension_error: MomentSummary  # [N] from the target at rest
    margin: float  # [rad] smallest of a turning joint to its limit; nan if unknown
    loops: tuple[LoopTimes, ...]
    transcripts: tuple[str, ...]  # each once


def summarise(
    name: str, data: SessionData, rows: Iterable[CommandRow], rcm: JointRcm, config: ReportConfig
) -> SessionSummary:
    """Reduce a session."""
    recording, condition = data.recording, data.recording.condition
    moving, tension = rcm_while_moving(data), measured_tension(data, config.topics.tension)
    own = moments(rcm.while_moving)
    return SessionSummary(
        name=name,
        started=recording.start * 1e-9,
        duration=recording.duration,
        is_complete=_is_complete(data, config),
        commit=condition.latest("code").get("commit", ""),
        phrases=data.phrases,
        knows_intent=bool(data.intended),
        trials=tuple(trials(data, config)),
        given=tuple(map(_given, rows)),
        ignored=sum(1 for heard in data.heard if not heard.command),
        rcm=moments(moving),
        rcm_joints=replace(own, largest=max(own.largest, rcm.largest)),
        rcm_above=int(np.count_nonzero(moving > config.rcm_limit)),
        rcm_joints_above=int(np.count_nonzero(rcm.while_moving > config.rcm_limit)),
        tension=statistics(tension["tension"]).largest,
        tension_with_target=statistics(tension_with_target(data)).largest,
        tension_error=moments(tension_error(data)),
        margin=smallest_margin(data),
        loops=_loops(data, config),
        transcripts=tuple(dict.fromkeys(heard.transcript for heard in data.heard)),
    )


def moments(values: Track) -> MomentSummary:
    """Count, sum of squares and largest of the finite numbers, shape (n,)."""
    x = values[np.isfinite(values)]
    if not len(x):
        return MomentSummary()
    return MomentSummary(len(x), float(x @ x), float(x.max()))


def from_json(values: dict[str, Any]) -> SessionSummary:
    """Read back what `dataclasses.asdict` made of a summary.

    Raises:
        TypeError, KeyError: It is something else.
    """
    return SessionSummary(
        **{
            **values,
            "phrases": tuple(values["phrases"]),
            "transcripts": tuple(values["transcripts"]),
            "trials": tuple(PhraseTrial(**trial) for trial in values["trials"]),
            "given": tuple(GivenCommand(**given) for given in values["given"]),
            "loops": tuple(LoopTimes(**loop) for loop in values["loops"]),
            **{k: MomentSummary(**values[k]) for k in ("rcm", "rcm_joints", "tension_error")},
        }
    )


def _is_complete(data: SessionData, config: ReportConfig) -> bool:
    recording = data.recording
    lost = recording.missing or recording.dropped or recording.cuts
    elsewhere = namespaces_of(vars(config.topics).values(), recording.topics)
    unread = data.undecodable or data.missing_fields or elsewhere
    changed = recording.clock_steps or data.clock_lags or data.clock_offsets
    return not (recording.condition.troubles or lost or unread or changed)


def _given(row: CommandRow) -> GivenCommand:
    return GivenCommand(
        command=row.command,
        decision_latency=row.decision_latency,
        reaction=row.reaction,
        outcome=row.outcome,
        message=row.message,
        is_partial=row.heard is not None and row.heard.is_partial,
        given_by=row.given_by,
    )


def _loops(data: SessionData, config: ReportConfig) -> tuple[LoopTimes, ...]:
    found = []
    for loop in data.loops:
        timing = loop_timing(loop, config.late_factor)
        found.append(LoopTimes(loop.topic, timing.period.count, timing.late))
    return tuple(found)
