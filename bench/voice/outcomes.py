# SPDX-License-Identifier: BSD-3-Clause
"""What came of trials: right, nothing, another command, or the opposite of what was said."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal

import numpy as np

from bench.voice.hearing.pieces import SceneRecord
from session_log.report.bounds import at_least, at_most
from support.figures import Figure, share
from voice_assist.config import load_voice_config

# The sense in which a command moves: more pull, less pull, or an end to it all.
SENSE = {
    **{"tense": 1, "pull more": 1, "release": -1, "pull less": -1},
    **{"stop": 0, "terminate": 0},
}
Verdict = Literal["right", "nothing", "wrong", "opposite"]


@cache
def motions() -> frozenset[str]:
    """Commands that make the robot move."""
    return frozenset(c.phrase for c in load_voice_config().commands.commands if c.is_motion)


def is_opposite(said: str, taken: str) -> bool:
    """Whether a command would move the robot against what was said.

    So do "pull less" for "pull more", "release" for "tense", "release" for "pull more", and any
    motion for "stop" or "terminate". "hey robot" asks for no sense, so none is against it.
    """
    if taken not in motions() or said not in SENSE:
        return False
    return SENSE[taken] != SENSE[said]


def verdict(said: str, taken: Iterable[str]) -> Verdict:
    """The worst that came of a clip in which a command is said."""
    commands = set(taken)
    if any(is_opposite(said, command) for command in commands):
        return "opposite"
    if commands - {said}:
        return "wrong"
    return "right" if commands else "nothing"


@dataclass(frozen=True)
class TrialTally:
    """Verdicts of some trials."""

    n: int
    right: int
    nothing: int
    wrong: int  # another command, the opposite too
    opposite: int
    by_voice: tuple[TrialTally, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """With exact one-sided bounds at 95 % each."""
        return {
            "n": self.n,
            "right": self.right,
            "nothing": self.nothing,
            "wrong": self.wrong,
            "opposite": self.opposite,
            "right_at_least": at_least(self.right, self.n),
            "wrong_at_most": at_most(self.wrong, self.n),
            "opposite_at_most": at_most(self.opposite, self.n),
        }


def tally(records: Iterable[SceneRecord]) -> TrialTally:
    """Count trials, each of which says a command."""
    found, voices = Counter[Verdict](), dict[str, Counter[Verdict]]()
    for record in records:
        came = verdict(text(record), record.heard.taken)
        found[came] += 1
        voices.setdefault(voice(record), Counter())[came] += 1
    return replace(_of(found), by_voice=tuple(map(_of, voices.values())))


def _of(found: Counter[Verdict]) -> TrialTally:
    wrong = found["wrong"] + found["opposite"]
    return TrialTally(found.total(), found["right"], found["nothing"], wrong, found["opposite"])


def by(records: Sequence[SceneRecord], key: Callable[[SceneRecord], str]) -> dict[str, TrialTally]:
    """A tally for each group, by its name."""
    groups: dict[str, list[SceneRecord]] = {}
    for record in records:
        groups.setdefault(key(record), []).append(record)
    return {name: tally(groups[name]) for name in sorted(groups)}


def engine(record: SceneRecord) -> str:
    """Engine that spoke it."""
    return str(record.label["engine"])


def text(record: SceneRecord) -> str:
    """What was said."""
    return str(record.label["text"])


def voice(record: SceneRecord) -> str:
    """Engine and voice that spoke it."""
    return f"{record.label['engine']}:{record.label['voice']}"


def right(name: str, count: TrialTally, target: float | None = None) -> Figure:
    """Share that was right."""
    groups = [(one.right, one.n) for one in count.by_voice]
    return share(f"{name}: right", count.right, count.n, in_percent(target), groups=groups)


def others(name: str, count: TrialTally, targets: bool = False) -> list[Figure]:
    """Share of another command, and how many of these go against what was said."""
    limit, none = (0.1, 0.0) if targets else (None, None)
    against = [(one.opposite, one.n) for one in count.by_voice]
    return [
        another(name, count, limit),
        share(f"{name}: opposite", count.opposite, count.n, none, at_most=True, groups=against),
    ]


def another(name: str, count: TrialTally, limit: float | None, note: str = "") -> Figure:
    """Share of another command, the opposite too; the limit in per cent."""
    groups, what = [(one.wrong, one.n) for one in count.by_voice], f"{name}: another command"
    return share(what, count.wrong, count.n, limit, at_most=True, note=note, groups=groups)


def share_of_voices(
    name: str,
    trials: Iterable[tuple[str, bool]],
    target: float | None = None,
    at_most: bool = False,
    note: str = "",
) -> Figure:
    """Share of trials [%], whose bound counts voices.

    Args:
        name: Of the figure.
        trials: Voice of each, and whether it counts; at least one.
        target: In per cent.
        at_most: Whether few are good.
        note: Conditions, beside the counts.
    """
    found: dict[str, list[bool]] = {}
    for who, counts in trials:
        found.setdefault(who, []).append(counts)
    groups = [(sum(some), len(some)) for some in found.values()]
    count, n = (sum(column) for column in zip(*groups, strict=True))
    return share(name, count, n, target, at_most, note, groups=groups)


def in_percent(target: float | None) -> float | None:
    """A target for a share as one for a figure in per cent."""
    return None if target is None else round(100.0 * target, 6)


def latencies(records: Iterable[SceneRecord]) -> dict[str, list[float]]:
    """Times from the end of speech to the first decision of the trials that were right [ms]."""
    right_ones: dict[str, list[SceneRecord]] = {}
    for record in records:
        if verdict(text(record), record.heard.taken) == "right":
            right_ones.setdefault(text(record), []).append(record)
    return {command: delays(some, command) for command, some in right_ones.items()}


def hours(records: Iterable[SceneRecord]) -> float:
    """Length of all scenes [h]."""
    return sum(float(r.label["seconds"]) for r in records) / 3600.0


def processor(records: Iterable[SceneRecord]) -> float:
    """Share of the scenes' length that hearing them took on one core [%]."""
    every = list(records)
    return 100.0 * sum(r.heard.compute for r in every) / sum(r.heard.streamed for r in every)


def delays(records: Iterable[SceneRecord], command: str = "stop") -> list[float]:
    """Times from the end of the word to the first time that a command is taken [ms].

    Below 0 where it came within the word.
    """
    first = (
        (next(s.at for s in r.heard.said if s.is_taken and s.command == command), r.label["end"])
        for r in records
    )
    return [1e3 * (at - end) for at, end in first]


def fired(records: Iterable[SceneRecord], *known: str) -> list[dict[str, Any]]:
    """Every command that was taken, with what is known of its scene by some keys of its label."""
    return [
        {
            "taken": one.command,
            "confidence": one.confidence,
            "origin": one.origin,
            "heard": one.text,
            "at": one.at,
            **{key: record.label[key] for key in known},
        }
        for record in records
        for one in record.heard.said
        if one.is_taken
    ]


def quantiles(times: Sequence[float]) -> dict[str, float]:
    """Percentiles of times."""
    return {f"p{q}": float(np.percentile(times, q)) for q in (50, 95, 99)}


def misses(records: Iterable[SceneRecord]) -> list[dict[str, Any]]:
    """Trials that were not right, to be listened to."""
    return [
        {
            "verdict": verdict(r.label["text"], r.heard.taken),
            **{key: r.label[key] for key in ("text", "engine", "voice", "path")},
            "taken": r.heard.taken,
            "heard": [one.text for one in r.heard.said],
            "why": [one.why for one in r.heard.said if one.why],
            "confidence": [one.confidence for one in r.heard.said],
        }
        for r in records
        if verdict(r.label["text"], r.heard.taken) != "right"
    ]
