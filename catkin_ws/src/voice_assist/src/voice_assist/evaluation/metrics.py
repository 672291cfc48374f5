# SPDX-License-Identifier: BSD-3-Clause
"""Outcomes of clips to the figures of an evaluation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from voice_assist.evaluation.evaluator import ClipOutcome

QUANTILES = {"p50": 50, "p95": 95, "p99": 99}


def summarize(outcomes: Sequence[ClipOutcome], phrases: Iterable[str]) -> dict[str, Any]:
    """Counts, rates and latencies, ready for JSON.

    A clip with a command is correct if that command was taken and no other, confused if another
    was, and rejected if none was. In a clip without one, every command taken counts.
    """
    positives = [outcome for outcome in outcomes if outcome.clip.phrase]
    negatives = [outcome for outcome in outcomes if not outcome.clip.phrase]
    commands = {
        phrase: _command([o for o in positives if o.clip.phrase == phrase]) for phrase in phrases
    }
    correct = sum(entry["correct"] for entry in commands.values())
    compute, streamed = sum(o.compute for o in outcomes), sum(o.streamed for o in outcomes)
    return {
        "n": len(outcomes),
        "commands": commands,
        "accuracy": correct / len(positives) if positives else None,
        "negatives": _negatives(negatives),
        "latency_ms": {phrase: _latency(positives, phrase) for phrase in commands},
        "real_time_factor": compute / streamed if streamed else None,
    }


def verdict(outcome: ClipOutcome) -> str:
    """`correct`, `rejected` or the command that it was confused with; for a positive."""
    others = [t.command for t in outcome.taken if t.command != outcome.clip.phrase]
    if others:
        return others[0]
    return "correct" if outcome.taken else "rejected"


def _command(outcomes: Sequence[ClipOutcome]) -> dict[str, Any]:
    verdicts = Counter(verdict(outcome) for outcome in outcomes)
    correct, rejected = verdicts.pop("correct", 0), verdicts.pop("rejected", 0)
    return {
        "n": len(outcomes),
        "correct": correct,
        "rejected": rejected,
        "confused": dict(verdicts),
    }


def _negatives(outcomes: Sequence[ClipOutcome]) -> dict[str, Any]:
    taken = Counter(t.command for outcome in outcomes for t in outcome.taken)
    hours = sum(outcome.seconds for outcome in outcomes) / 3600.0
    return {
        "n": len(outcomes),
        "hours": hours,
        "accepted": taken.total(),
        "accepted_per_hour": taken.total() / hours if hours else None,
        "by_command": dict(taken),
    }


def _latency(positives: Sequence[ClipOutcome], phrase: str) -> dict[str, float | None]:
    """Of the clips of a phrase that were taken for it; the first time it was taken counts."""
    values = [
        1e3 * outcome.taken[0].latency
        for outcome in positives
        if outcome.clip.phrase == phrase and verdict(outcome) == "correct"
    ]
    if not values:
        return dict.fromkeys(QUANTILES)
    return {name: float(np.percentile(values, q)) for name, q in QUANTILES.items()}
