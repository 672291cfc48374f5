# SPDX-License-Identifier: BSD-3-Clause
"""Enrolment of stand-in surgeons: errors before and after, loss on others, time and memory.

All go through the pipeline of the node in quiet to moderate noise, armed. What is measured is kept
under .cache/enrolment/, so it goes on where it was interrupted. In the environment: SHARE the part
of the surgeons to take, MINUTES after which no more are begun, REPETITIONS a list such as "3,5,10".
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import asdict
from itertools import product

import torch

from bench.common.resumable import MINUTES, measured, share_of, write_details
from bench.enrolment.cast import Surgeon, surgeons
from bench.enrolment.pieces import Counts, EnrolmentPiece, is_done, piece
from support.figures import Figure, share

FULL = (3, 5, 10)  # repetitions
REPETITIONS = tuple(map(int, os.environ.get("REPETITIONS", "3,5,10").split(",")))
FEWEST = 20  # surgeons


def measure() -> list[Figure]:
    """Measure all that is asked for, and give the figures of all that there is."""
    torch.set_num_threads(1)
    began, cast = time.monotonic(), share_of(surgeons())
    first, *more = REPETITIONS
    order = [*product(range(len(cast)), (0, first))]  # surgeon by surgeon: a part is worth most
    order += [(index, repetitions) for repetitions, index in product(more, range(len(cast)))]
    for index, repetitions in order:
        surgeon, stranger = cast[index], cast[(index + 1) % len(cast)]
        is_over = time.monotonic() - began > 60.0 * MINUTES
        if is_over and not is_done(surgeon, repetitions):
            continue
        found = piece(surgeon, stranger, repetitions)
        print(f"{repetitions:2} {surgeon}: {found.tested.right} of {found.tested.n}", flush=True)
    done = sum(is_done(s, n) for s in cast for n in (0, *REPETITIONS))
    full = len(surgeons()) * (1 + len(FULL))
    return [measured(done, "surgeons enrolled", full), *_all(cast, done)]


def _all(cast: Sequence[Surgeon], count: int) -> list[Figure]:
    """Figures of those surgeons of whom base and so many repetitions are there."""
    figures, details = [], []
    for repetitions in REPETITIONS:
        done = [
            s
            for s, t in zip(cast, [*cast[1:], cast[0]], strict=True)
            if _is_whole(s, t, repetitions)
        ]
        if not done:
            continue
        pairs = [(piece(s, s, 0), piece(s, s, repetitions)) for s in done]
        theirs = [cast[(cast.index(s) + 1) % len(cast)] for s in done]
        strangers = [piece(s, s, 0).stranger for s in theirs]
        figures += _of(repetitions, pairs, strangers)
        details += [asdict(after) for _, after in pairs]
    details += [asdict(piece(s, s, 0)) for s in cast if is_done(s, 0)]
    write_details("enrolment_surgeons.json", count, {"surgeons": details})
    return figures


def _is_whole(surgeon: Surgeon, stranger: Surgeon, repetitions: int) -> bool:
    """Whether all is there that a comparison needs."""
    return is_done(surgeon, 0) and is_done(surgeon, repetitions) and is_done(stranger, 0)


def _of(
    repetitions: int,
    pairs: Sequence[tuple[EnrolmentPiece, EnrolmentPiece]],
    strangers: Sequence[Counts],
) -> list[Figure]:
    """Figures after so many repetitions; `strangers` is what the base hears of their voices.

    The worst quarter are those whose first repetitions the base hears worst. They are judged by
    the others: a surgeon may be among the worst by chance, and chance does not repeat itself.
    """
    of = f"{repetitions} repetitions"
    worst = sorted(pairs, key=lambda pair: _error([pair[0].first]), reverse=True)
    worst = worst[: max(len(pairs) // 4, 1)]
    worst_before, worst_after = ([p[i].later for p in worst] for i in (0, 1))
    over = _error(worst_after) / max(_error(worst_before), 1e-9)
    lost = _error([p[1].stranger for p in pairs]) - _error(strangers)
    figures = [
        Figure(f"{of}: surgeons", len(pairs), "", FEWEST, at_most=False),
        _share(f"{of}: error of all, base", [p[0].tested for p in pairs]),
        _share(f"{of}: error of all, profile", [p[1].tested for p in pairs]),
        _share(f"{of}: worst quarter, base", worst_before),
        _share(f"{of}: worst quarter, profile", worst_after),
        Figure(f"{of}: worst quarter, profile over base", over, "", 0.5),
        Figure(f"{of}: error on another's voice, profile less base", 100.0 * lost, "points", 1.0),
    ]
    for name, who in (("base", 0), ("profile", 1)):
        tested = [p[who].tested for p in pairs]
        talk, near = [p[who].talk for p in pairs], [p[who].near for p in pairs]
        figures += [
            _another(f"{of}: another command, {name}", tested),
            _another(f"{of}: false commands in talk, {name}", talk),
            _another(f"{of}: false commands in near misses, {name}", near),
        ]
    seconds = [after.seconds for _, after in pairs]
    return [
        *figures,
        Figure(f"{of}: to learn, longest", max(seconds), "s of CPU", 300.0),
        Figure(f"{of}: to learn, mean", sum(seconds) / len(seconds), "s of CPU"),
        Figure(f"{of}: memory, largest", max(after.memory for _, after in pairs), "MB"),
        Figure(f"{of}: takes refused", sum(after.refused for _, after in pairs), ""),
    ]


def _error(counts: Sequence[Counts]) -> float:
    n = sum(c.n for c in counts)
    return 1.0 - sum(c.right for c in counts) / max(n, 1)


def _share(name: str, counts: Sequence[Counts]) -> Figure:
    return _of_surgeons(name, [(c.n - c.right, c.n) for c in counts])


def _another(name: str, counts: Sequence[Counts]) -> Figure:
    return _of_surgeons(name, [(c.another, c.n) for c in counts])


def _of_surgeons(name: str, counts: Sequence[tuple[int, int]]) -> Figure:
    wrong, n = (sum(column) for column in zip(*counts, strict=True))
    return share(name, wrong, n, at_most=True, groups=counts)
