# SPDX-License-Identifier: BSD-3-Clause
"""What an hour of listening came to: memory, latency and its drift, what was lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import linregress
from scipy.stats import t as student

from support.figures import Figure, share

EVERY = 2.5  # [s] from one command to the next
SETTLED = 300.0  # [s] after which memory is compared with that at the end


@dataclass(frozen=True)
class SpokenCommand:
    """A command in the stream."""

    text: str
    begin: float  # [s] stream time of its clip's beginning
    end: float  # [s] of its end of speech


@dataclass(frozen=True)
class TakenCommand:
    """One that was taken."""

    text: str
    at: float  # [s] stream time
    latency: float  # [s] from the end of speech


@dataclass(frozen=True)
class SoakResult:
    """What the hour came to."""

    seconds: float  # [s] of stream
    said: int
    answers: list[TakenCommand]
    memory: list[tuple[float, float]]  # [s] of stream, resident bytes
    lost: int  # samples that the pipeline missed
    dropped: int  # frames that a queue of the node's length would have given up
    behind: float  # [s] most that the work was behind the stream
    compute: float  # [s] of CPU


def figures(found: SoakResult) -> list[Figure]:
    """Memory, latency and their drift, and what was lost."""
    start = next(size for at, size in found.memory if at >= min(SETTLED, found.memory[-1][0]))
    end = found.memory[-1][1]
    times = [1e3 * a.latency for a in found.answers]
    right = len(found.answers)
    slope, error = drift([a.at / 3600.0 for a in found.answers], _about_own_median(found.answers))
    drifts = slope, "ms/h", 5.0, True, "(lock-step: stream time and CPU time)"
    return [
        Figure("soak: memory after five minutes", start / 1e6, "MB", 600.0),
        Figure("soak: memory at the end", end / 1e6, "MB", 600.0),
        Figure("soak: memory grown", (end - start) / 1e6, "MB", 20.0),
        Figure("soak: drift of latency", *drifts, slope - error, slope + error),
        Figure("soak: latency p50", float(np.median(times)), "ms"),
        Figure("soak: lost samples", found.lost, "", 0.0),
        Figure("soak: frames that the queue would drop", found.dropped, "", 0.0),
        Figure("soak: most behind the stream", 1e3 * found.behind, "ms"),
        share("soak: taken", right, found.said),
        Figure("soak: real-time factor", found.compute / found.seconds, ""),
    ]


def _about_own_median(answers: Sequence[TakenCommand]) -> list[float]:
    """Latencies less the median of their command's, which differ between commands [ms]."""
    groups: dict[str, list[float]] = {}
    for answer in answers:
        groups.setdefault(answer.text, []).append(answer.latency)
    return [1e3 * (a.latency - float(np.median(groups[a.text]))) for a in answers]


def drift(at: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """Slope of values over time, and half its 95 % interval, by least squares.

    Args:
        at: Times; at least three.
        values: Of each.
    """
    fit = linregress(at, values)
    width = float(student.ppf(0.975, len(at) - 2)) * float(fit.stderr)
    return float(fit.slope), width


def answers_to(
    said: Sequence[SpokenCommand], matches: Sequence[tuple[float, str]]
) -> list[TakenCommand]:
    """The first match of each command's own words, from its beginning to the next command's.

    Args:
        said: Commands in their order.
        matches: Time [s] and command of what was taken.
    """
    found = []
    for one in said:
        until = one.begin + EVERY
        own = [at for at, command in matches if command == one.text and one.begin < at < until]
        if own:
            found.append(TakenCommand(one.text, own[0], own[0] - one.end))
    return found
