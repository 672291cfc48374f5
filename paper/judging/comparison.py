# SPDX-License-Identifier: BSD-3-Clause
"""Inputs beside each other: time to motion, refusals and wrong commands, with intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from paper.judging.outcomes import PhraseOutcome
from paper.play.plan import MOTIONS
from support.figures import Figure, over_groups, share

INTERVAL = (0.025, 0.975)  # quantiles of a mean's interval with 95 %
Outcomes = Sequence[PhraseOutcome]
NOTES = {
    "voice": "from the end of the word",
    "pedal": "from the press, by a program: a person's wrong presses are not in it",
}


def comparison(inputs: Mapping[str, Sequence[Outcomes]]) -> list[Figure]:
    """Figures of each input that was used; none where that is the voice alone.

    Args:
        inputs: Outcomes of each voice, by the name of the input.
    """
    used = {}
    for name, voices in inputs.items():
        counted = [[o for o in voice if o.command and o.is_counted] for voice in voices]
        if meant := [voice for voice in counted if voice]:
            used[name] = meant
    if set(used) <= {"voice"}:
        return []
    return [figure for name, meant in used.items() for figure in _of_input(name, meant)]


def _of_input(name: str, meant: Sequence[Outcomes]) -> list[Figure]:
    found = _times(name, [[o.acted for o in voice if _is_timed(o)] for voice in meant])
    kinds: dict[str, Callable[[PhraseOutcome], bool]] = {
        "refused by the robot": lambda o: bool(o.refusal),
        "wrong": lambda o: bool(set(o.taken) - {o.command}),
        "missed": lambda o: not o.taken,
    }
    for kind, is_so in kinds.items():
        groups = [(sum(map(is_so, voice)), len(voice)) for voice in meant]
        count, trials = map(sum, zip(*groups, strict=True))
        title = f"{name}: commands {kind}"
        found.append(share(title, count, trials, at_most=True, groups=groups))
    return found


def _is_timed(o: PhraseOutcome) -> bool:
    return o.command in MOTIONS and math.isfinite(o.acted)


def _times(name: str, by_voice: Sequence[Sequence[float]]) -> list[Figure]:
    """Mean, with its interval where voices can be drawn anew, and p95 of the times to motion."""
    groups = [(sum(times), len(times)) for times in by_voice if times]
    times = [time for voice in by_voice for time in voice]
    if not times:
        return []
    title, note = f"{name}: time to motion, mean", f"n={len(times)}; {NOTES[name]}"
    low, high = (over_groups(groups, q) if len(groups) > 1 else None for q in INTERVAL)
    return [
        Figure(title, float(np.mean(times)), "s", None, True, note, low, high),
        Figure(f"{name}: time to motion, p95", float(np.percentile(times, 95)), "s"),
    ]
