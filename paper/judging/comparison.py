# SPDX-License-Identifier: BSD-3-Clause
"""Inputs beside each other: time to motion, refusals and wrong commands, with intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from paper.judging.outcomes import PhraseOutcome
from paper.play.plan import MOTIONS
from support.figures import Figure, share

Z = 1.96  # of a mean's interval with 95 %
NOTES = {
    "voice": "from the end of the word",
    "pedal": "from the press, by a program: a person's wrong presses are not in it",
}


def comparison(inputs: Mapping[str, Sequence[PhraseOutcome]]) -> list[Figure]:
    """Figures of each input that was used; none where that is the voice alone.

    Args:
        inputs: Outcomes by the name of the input.
    """
    counted = {n: [o for o in all_ if o.command and o.is_counted] for n, all_ in inputs.items()}
    used = {name: meant for name, meant in counted.items() if meant}
    if set(used) <= {"voice"}:
        return []
    return [figure for name, meant in used.items() for figure in _of_input(name, meant)]


def _of_input(name: str, meant: Sequence[PhraseOutcome]) -> list[Figure]:
    times = [o.acted for o in meant if o.command in MOTIONS and math.isfinite(o.acted)]
    refused = sum(bool(o.refusal) for o in meant)
    wrong = sum(bool(set(o.taken) - {o.command}) for o in meant)
    missed = sum(not o.taken for o in meant)
    found = []
    if times:
        mean, half = float(np.mean(times)), Z * float(np.std(times)) / math.sqrt(len(times))
        title, note = f"{name}: time to motion, mean", f"n={len(times)}; {NOTES[name]}"
        found.append(Figure(title, mean, "s", None, True, note, mean - half, mean + half))
        p95 = float(np.percentile(times, 95))
        found.append(Figure(f"{name}: time to motion, p95", p95, "s"))
    for kind, count in (("refused by the robot", refused), ("wrong", wrong), ("missed", missed)):
        found.append(share(f"{name}: commands {kind}", count, len(meant), at_most=True))
    return found
