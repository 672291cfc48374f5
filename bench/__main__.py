# SPDX-License-Identifier: BSD-3-Clause
"""`make bench`: all sets of figures, or those named (`make bench ONLY="motion voice.near"`)."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterable, Sequence

from rich.console import Console

from bench.common.resumable import kept
from support.figures import Figure, run
from support.interrupt import end_as_by_ctrl_c

SETS = {  # name for people, also of the file of results: the module that measures
    "motion": "bench.motion.suite",
    "torque_tension": "bench.tension.suite",
    "voice": "bench.voice.suite",
    "enrolment": "bench.enrolment.suite",
    "speaker": "bench.voice.speaker_gate",
    "sessions": "bench.recording.suite",
    "safety": "bench.safety.suite",
    "kinova": "bench.kinova.suite",
    "site": "bench.site.suite",
    "system": "bench.system",
    "display": "bench.display",
}


def main(argv: Sequence[str]) -> int:
    """Run the sets named, or all; returns 2 for a name that is none."""
    unknown = [name for name in argv if not _exists(name)]
    if unknown:
        for name in unknown:
            print(f"no such set of figures: {name}; allowed: {', '.join(_allowed(name))}")
        return 2
    console = Console()
    missed = 0
    for name in argv or SETS:
        file = name.replace(".", "/")
        figures = run(file, kept(file, _measure(name)), console)
        missed += sum(f.is_met is False for f in figures)
    if missed:
        console.print(f"[yellow]{missed} targets missed; they are marked above.[/yellow]")
    return 0


def _exists(name: str) -> bool:
    return name in _allowed(name)


def _allowed(name: str) -> Sequence[str]:
    """The sets; those of a part of a known set: the parts of that set."""
    family, _, part = name.partition(".")
    if family not in SETS or not part:
        return tuple(SETS)
    parts: Iterable[str] = getattr(importlib.import_module(SETS[family]), "PARTS", ())
    return [f"{family}.{one}" for one in parts] or [family]


def _measure(name: str) -> Callable[[], list[Figure]]:
    """What measures a set, or a part of it such as "voice.near"."""
    family, _, part = name.partition(".")
    module = importlib.import_module(SETS[family])
    measure: Callable[[], list[Figure]] = module.PARTS[part] if part else module.measure
    return measure


if __name__ == "__main__":
    end_as_by_ctrl_c()
    sys.exit(main(sys.argv[1:]))
