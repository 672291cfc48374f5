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


def _set_by(file: Path) -> int:
    return round(1e9 * float(file.read_text(encoding="utf-8") or 0.0))


time.time_ns = lambda: _REAL() + sum(map(_set_by, _FILES))
time.time = lambda: 1e-9 * time.time_ns()
