# SPDX-License-Identifier: BSD-3-Clause
"""Pieces of a long measurement, done by processes; each writes what it finishes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from pathlib import Path
from typing import TypeVar

_T = TypeVar("_T")


def do_pieces(
    part: str,
    missing: Sequence[tuple[_T, Path]],
    one: Callable[[_T, Path], None],
    pool: Executor,
    jobs: int,
    minutes: float,
) -> None:
    """Do pieces, a few at a time, and say how far it is.

    Args:
        part: Names the measurement.
        missing: Pieces, and the file of each.
        one: Does a piece.
        pool: Processes to do it in.
        jobs: Pieces under way at once.
        minutes: After which no more pieces are begun.
    """
    began, waiting, done = time.monotonic(), iter(missing), 0
    running: set[Future[None]] = {
        pool.submit(one, *job) for _, job in zip(range(jobs), waiting, strict=False)
    }
    while running:
        finished, running = wait(running, return_when=FIRST_COMPLETED)
        for future in finished:
            future.result()
        done += len(finished)
        spent = time.monotonic() - began
        print(f"{part}: {done} of {len(missing)} after {spent:.0f} s", flush=True)
        if spent < 60.0 * minutes:
            turns = zip(finished, waiting, strict=False)  # a new piece for each finished one
            running |= {pool.submit(one, *job) for _, job in turns}
