# SPDX-License-Identifier: BSD-3-Clause
"""`make bench`: all sets of figures, or those named (`make bench ONLY="motion voice"`)."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence

from rich.console import Console

from bench.figures import run

SETS = ("motion", "voice", "sessions", "system")


def main(argv: Sequence[str]) -> int:
    """Run the sets named, or all; returns 2 for a name that is none."""
    unknown = [name for name in argv if name not in SETS]
    if unknown:
        print(f"no such set of figures: {', '.join(unknown)}; allowed: {', '.join(SETS)}")
        return 2
    console = Console()
    missed = 0
    for name in argv or SETS:
        measure = importlib.import_module(f"bench.{name}").measure
        missed += sum(f.is_met is False for f in run(name, measure, console))
    if missed:
        console.print(f"[yellow]{missed} targets missed; they are marked above.[/yellow]")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
