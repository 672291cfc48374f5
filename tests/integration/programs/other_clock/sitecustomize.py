# SPDX-License-Identifier: BSD-3-Clause
"""Python reads this at its start where the folder is on PYTHONPATH: a wall clock that can be set.

The files named by WALL_CLOCK hold how far it is ahead of the machine's [s]; their numbers add up.
WALL_CLOCK_<node> names those of one node. The steady clock stays.
"""

import os
import sys
import time
from pathlib import Path

_NODE = next((word[8:] for word in sys.orig_argv if word.startswith("__name:=")), "")
_NAMES = os.environ.get(f"WALL_CLOCK_{_NODE}") or os.environ["WALL_CLOCK"]
_FILES = [Path(name) for name in _NAMES.split(os.pathsep)]
_REAL = time.time_ns


_READ: dict[Path, tuple[tuple[int, int], int]] = {}  # of each file: which one, and what it says


def _set_by(file: Path) -> int:
    """Read again only where the file was replaced: nodes ask some thousand times a second."""
    status = file.stat()
    which = status.st_ino, status.st_mtime_ns
    known = _READ.get(file)
    if known is None or known[0] != which:
        known = which, round(1e9 * float(file.read_text(encoding="utf-8") or 0.0))
        _READ[file] = known
    return known[1]


time.time_ns = lambda: _REAL() + sum(map(_set_by, _FILES))
time.time = lambda: 1e-9 * time.time_ns()
