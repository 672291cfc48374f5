# SPDX-License-Identifier: BSD-3-Clause
"""What `make setup` costs in a fresh clone, on a machine that has Debian's packages already."""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from pathlib import Path

from support.figures import ROOT, Figure

OF_MAKE = ("MAKEFLAGS", "MAKELEVEL", "MFLAGS")  # that this is run by
PARTS = {"repository": ".git", "Python packages": ".venv", "workspace": "catkin_ws"}
NOTE = "as committed, Debian's packages there, Python's from pip's cache where it has them"


def measure(root: Path = ROOT) -> list[Figure]:
    """Clone, set up, and measure what that took.

    Args:
        root: Of the repository.

    Raises:
        RuntimeError: Cloning or set-up failed; with the last lines that it printed.
    """
    with tempfile.TemporaryDirectory() as name:
        clone = Path(name) / "clone"
        _run(["git", "clone", "--quiet", f"file://{root}", str(clone)], root)
        began = time.monotonic()
        _run(["make", "setup"], clone)
        took = time.monotonic() - began
        sizes = {part: _size(clone / folder) for part, folder in PARTS.items()}
        whole = _size(clone)
    return [
        Figure("set-up: time", took, "s", note=NOTE),
        Figure("set-up: on disk, all", whole, "MB"),
        *(Figure(f"set-up: on disk, {part}", size, "MB") for part, size in sizes.items()),
    ]


def _run(command: list[str], folder: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name not in OF_MAKE}
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        last = "\n".join((done.stdout + done.stderr).splitlines()[-10:])
        raise RuntimeError(f"{' '.join(command)} failed:\n{last}")


def _size(folder: Path) -> float:
    """Disk that a folder takes [MB], a file with several names once."""
    if not folder.exists():
        return 0.0
    printed = subprocess.run(["du", "-sk", folder], capture_output=True, text=True, check=True)
    return int(printed.stdout.split()[0]) * 1024 / 1e6
