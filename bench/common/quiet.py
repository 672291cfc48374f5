# SPDX-License-Identifier: BSD-3-Clause
"""Keeps C libraries off the terminal while figures are measured."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

STANDARD_OUTPUT = 1  # file descriptor


@contextmanager
def quiet() -> Iterator[None]:
    """Drop what C code prints meanwhile: PyBullet announces its solver for each new world."""
    c_library = ctypes.CDLL(None)
    sys.stdout.flush()
    c_library.fflush(None)
    kept = os.dup(STANDARD_OUTPUT)
    with Path(os.devnull).open("wb") as nowhere:
        os.dup2(nowhere.fileno(), STANDARD_OUTPUT)
    try:
        yield
    finally:
        c_library.fflush(None)
        os.dup2(kept, STANDARD_OUTPUT)
        os.close(kept)
