# SPDX-License-Identifier: BSD-3-Clause
"""From the outcomes to figures beside the paper's."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from paper.config import PaperVoiceConfig
from paper.judging.outcomes import PhraseOutcome
from paper.play.plan import COMMANDS, MOTIONS, STOP
from support.figures import Figure, share

SYNTHETIC = "synthetic voices"
ACTION = {STOP: "receipt of it", **dict.fromkeys(MOTIONS, "first motion")}  # others: answer


@dataclass(frozen=True)
class VoiceResult:
    """All phrases of one voice."""

    voice: PaperVoiceConfig
    outcomes: tuple[PhraseOutcome, ...]

    @property
    def repetitions(self) -> list[PhraseOutcome]:
        """Those that count: said by the voice itself, and heard whole at the microphone."""
        return [o for o in self.outcomes if o.is_counted and o.is_whole]


@dataclass(frozen=True)
class CommandResult:
    """One command over some voices."""

    command: str
    said: int
    correct: int
    by_voice: tuple[tuple[int, int], ...]  # correct and said of each
    others: Counter[str]  # what else was taken, and "nothing"
    refused: int  # by the controller, of those that were taken
    decided: tuple[float, ...]  # [s] from the end of the sound
    acted: tuple[float, ...]  # [s]


def row(command: str, voices: Iterable[VoiceResult]) -> CommandResult:
    """Sum up one command over voices."""
    by_voice = [[o for o in t.repetitions if o.command == command] for t in voices]
    some = [o for one in by_voice for o in one]
    others: Counter[str] = Counter()
    for o in some:
        others.update(() if o.is_correct else [" and ".join(o.taken) or "nothing"])
    return CommandResult(
        command=command,
        said=len(some),
        correct=sum(o.is_correct for o in some),
        by_voice=_counts([[o.is_correct for o in one] for one in by_voice]),
        others=others,
        refused=sum(bool(o.refusal) for o in some),
        decided=_finite(o.decided for o in some),
        acted=_finite(o.acted for o in some),
    )


def figures(
    voices: Sequence[VoiceResult], paper: Mapping[str, float], hardware: str
) -> list[Figure]:
    """All figures of the experiment.

    Args:
        voices: What every voice said and what came of it.
        paper: Mean time to the robot's action by command, as the paper has it [s].
        hardware: That the paper used.
    """
    rows = [row(command, voices) for command in COMMANDS]
    found: list[Figure] = []
    for r in rows:
        found += _of_command(r, paper, hardware)
    found += _mean_action(rows, paper, hardware)
    found += _shares(voices)
    found += _talk(voices)
    torn = sum(not o.is_whole for t in voices for o in t.outcomes)
    helped = sum(not o.is_counted for t in voices for o in t.outcomes)
    refused = sum(r.refused for r in rows)
    found.append(Figure("commands heard and refused by the robot", refused, "commands"))
    found.append(Figure("phrases left out: sound torn by the player", torn, "phrases"))
    found.append(Figure("phrases left out: said so that the dialogue goes on", helped, "phrases"))
    return found


def _of_command(r: CommandResult, paper: Mapping[str, float], hardware: str) -> list[Figure]:
    if not r.said:
        return []
    wrong = ", ".join(f"{n} x {what}" for what, n in r.others.most_common())
    taken = wrong and f"taken: {wrong}"
    name = f"{r.command}: recognised"
    found = [share(name, r.correct, r.said, note=taken, groups=r.by_voice)]
    n = len(r.decided)
    if n:
        name = f"{r.command}: end of sound to decision"
        found.append(Figure(f"{name}, median", float(np.median(r.decided)), "s", note=f"(n={n})"))
        found.append(Figure(f"{name}, p95", float(np.percentile(r.decided, 95)), "s"))
    if r.acted:
        kind = ACTION.get(r.command, "answer")
        name = f"{r.command}: end of sound to the robot's {kind}"
        theirs = paper.get(r.command)
        note = f"(n={len(r.acted)}, {SYNTHETIC}; paper: people, {hardware})"
        found.append(Figure(f"{name}, mean", float(np.mean(r.acted)), "s", theirs, note=note))
        found.append(Figure(f"{name}, p95", float(np.percentile(r.acted, 95)), "s"))
    return found


def _mean_action(
    rows: Sequence[CommandResult], paper: Mapping[str, float], hardware: str
) -> list[Figure]:
    """Mean over commands of their means, as the paper's 1.7 s is."""
    seen = [r for r in rows if r.acted and r.command in paper]
    if not seen:
        return []
    ours = float(np.mean([np.mean(r.acted) for r in seen]))
    theirs = float(np.mean([paper[r.command] for r in seen]))
    note = f"({len(seen)} commands, {SYNTHETIC}; paper: people, {hardware})"
    name = "mean over commands: end of sound to the robot's action"
    return [Figure(name, ours, "s", theirs, note=note)]


def _shares(voices: Sequence[VoiceResult]) -> list[Figure]:
    groups = {
        "all voices": list(voices),
        "native voices": [t for t in voices if t.voice.is_native],
        "non-native voices": [t for t in voices if not t.voice.is_native],
        **{f"{t.voice.name} ({t.voice.accent})": [t] for t in voices},
    }
    found = []
    for name, some in groups.items():
        counts = _counts([[o.is_correct for o in t.repetitions if o.command] for t in some])
        if counts:
            correct, trials = map(sum, zip(*counts, strict=True))
            title = f"{name}: commands recognised"
            found.append(share(title, correct, trials, groups=counts))
    return found


def _talk(voices: Sequence[VoiceResult]) -> list[Figure]:
    by_voice = [[o for o in t.repetitions if not o.command] for t in voices]
    talk = [o for one in by_voice for o in one]
    if not talk:
        return []
    found = []
    for name, kinds in (("a motion", set(MOTIONS)), ("any command", set(COMMANDS))):
        wrong = [o for o in talk if kinds & set(o.taken)]
        words = ", ".join(f"{o.words!r} for {' and '.join(o.taken)}" for o in wrong)
        counts = _counts([[bool(kinds & set(o.taken)) for o in one] for one in by_voice])
        title, n = f"talk taken for {name}", len(wrong)
        found.append(share(title, n, len(talk), 0.0, at_most=True, note=words, groups=counts))
    return found


def _counts(by_voice: Iterable[Sequence[bool]]) -> tuple[tuple[int, int], ...]:
    """How many phrases of each voice hold, and of how many; voices without any are left out."""
    return tuple((sum(some), len(some)) for some in by_voice if some)


def _finite(values: Iterable[float]) -> tuple[float, ...]:
    return tuple(v for v in values if math.isfinite(v))
