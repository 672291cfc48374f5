# SPDX-License-Identifier: BSD-3-Clause
"""`make bench`: all figures, a family or a part (`make bench ONLY="motion voice.near"`).

All take days. Each part says in its module what makes it shorter; bench/common/resumable.py, how it
goes on where it was interrupted. The page of figures is made anew at the end.
"""

from __future__ import annotations

import argparse
import importlib
import subprocess
import sys
from collections.abc import Sequence

from rich.console import Console

from bench import page
from bench.catalogue import measurable, named
from bench.common.part import Part
from bench.common.resumable import PLACE, kept
from support.figures import RESULTS, run
from support.interrupt import end_as_by_ctrl_c


def main(argv: Sequence[str]) -> int:
    """Measure what is named, or all; 2 for a name that is none, 1 where a part failed."""
    parser = argparse.ArgumentParser(prog="make bench", description=__doc__)
    parser.add_argument("names", nargs="*", help="families or parts: motion voice.near")
    names = parser.parse_args(argv).names
    unknown = [name for name in names if not named(name)]
    for name in unknown:
        print(f"no such figures: {name}; allowed: {', '.join(_allowed(name))}")
    if unknown:
        return 2
    chosen = {part.name: part for name in names or measurable() for part in named(name)}
    if len(chosen) > 1:
        codes = [_by_itself(name) for name in chosen]  # of those that were killed, below 0
        return int(any(codes))
    (part,) = chosen.values()
    console, key = Console(), _decisions(part)
    measure = kept(part.file, part.measure)
    figures = run(part.file, measure, console, part.rooms, key, _is_of_other_code, part.bench)
    if missed := sum(f.is_met is False for f in figures):
        console.print(f"[yellow]{missed} targets missed; they are marked above.[/yellow]")
    if PLACE == RESULTS:
        page.write()
    return 0


def _by_itself(name: str) -> int:
    """Measure a part in a process of its own, which has one ROS master in its life; its exit code.

    So one that fails leaves the others.
    """
    return subprocess.call([sys.executable, "-m", "bench", name])


def _decisions(part: Part) -> str:
    """Key of what the present code decides on fixed clips; empty: no figure follows from it."""
    if not part.decides:
        return ""
    fingerprint = importlib.import_module("bench.voice.hearing.fingerprint")
    decided = fingerprint.present()
    if PLACE == RESULTS:
        fingerprint.note(decided)
    return str(decided[part.decides])


def _is_of_other_code() -> bool:
    """Whether pieces of sound that were heard by other code were counted."""
    pieces = sys.modules.get("bench.voice.hearing.pieces")
    return pieces is not None and bool(pieces.is_of_other_code())


def _allowed(name: str) -> Sequence[str]:
    """Families and parts; those of a part of a known family: the parts of that family."""
    every = list(measurable())
    family, _, part = name.partition(".")
    if part and (siblings := [one for one in every if one.startswith(f"{family}.")]):
        return siblings
    return sorted({one.partition(".")[0] for one in every})


if __name__ == "__main__":
    end_as_by_ctrl_c()
    sys.exit(main(sys.argv[1:]))
