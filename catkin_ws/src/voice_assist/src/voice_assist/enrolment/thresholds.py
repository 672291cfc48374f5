# SPDX-License-Identifier: BSD-3-Clause
"""From which confidence on each command is taken, by its risk, and what is to be expected of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from voice_assist.config.commands import NEVER_SURE, CommandConfig
from voice_assist.evaluation.exact_bounds import rate_at_most, share_at_most
from voice_assist.profile.thresholds import Setting

_LOWEST_HALT = 0.5  # [0, 1] a halt is never taken from less
_LOWEST_OTHER = 0.25  # [0, 1] nor what neither moves nor halts


@dataclass(frozen=True)
class ConfidenceEvidence:
    """Confidences with which one command was heard by what was learned from other takes."""

    own: tuple[float, ...]  # in takes of it, where its words were heard
    missed: int  # takes of it in which they were not
    against: tuple[float, ...]  # in talk and in what is no command


@dataclass(frozen=True)
class ExpectedErrors:
    """What a threshold is expected to do."""

    phrase: str
    min_confidence: float
    takes: int
    missed: int  # of them, below the threshold or not heard at all
    miss_at_most: float  # 95 % upper bound of the share
    false: int  # commands in the talk, above the threshold
    false_per_hour_at_most: float  # 95 % upper bound of the rate

    def to_setting(self) -> Setting:
        """As it lies in the profile."""
        return Setting(phrase=self.phrase, least_confidence=self.min_confidence)


def choose_threshold(command: CommandConfig, evidence: ConfidenceEvidence, margin: float) -> float:
    """The threshold of one command for one person.

    A motion's is raised above all that it was wrongly heard in, as long as its takes stay above; a
    halt's is lowered below its takes; what arms or ends is lowered only where nothing spoke
    against.

    Args:
        command: With the threshold for everybody.
        evidence: Of the person.
        margin: Kept to the takes that set it.
    """
    base = command.min_confidence
    lowest = min(evidence.own, default=1.0)
    highest = max(evidence.against, default=0.0)
    if command.is_motion:
        wanted = highest + margin
        room = max(lowest - margin, base)
        return round(min(max(base, wanted), room, NEVER_SURE), 3)
    floor = _LOWEST_HALT if command.is_halt else _LOWEST_OTHER
    lower = max(lowest - margin, highest + margin, floor)
    return round(min(base, lower), 3)


def expected_errors(
    command: CommandConfig,
    threshold: float,
    evidence: ConfidenceEvidence,
    talked: Sequence[float],
    hours: float,
) -> ExpectedErrors:
    """Misses and false commands at a threshold, with exact bounds.

    Args:
        command: Which one.
        threshold: The threshold.
        evidence: Of the person.
        talked: Confidences with which the command was heard in the person's talk.
        hours: Of that talk [h].
    """
    takes = len(evidence.own) + evidence.missed
    missed = evidence.missed + sum(sure < threshold for sure in evidence.own)
    false = sum(sure >= threshold for sure in talked)
    bound = share_at_most(missed, takes)
    return ExpectedErrors(
        command.phrase, threshold, takes, missed, bound, false, rate_at_most(false, hours)
    )
