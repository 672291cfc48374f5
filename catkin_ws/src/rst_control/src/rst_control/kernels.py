# SPDX-License-Identifier: BSD-3-Clause
"""The decorator of the core's compiled functions, with a cache on disk that is never stale.

Numba looks only at the file of a function to judge whether its cached code is still good, not at
the files of the functions it calls. So when the source of any kernel here has changed since, the
cached code of all of them is thrown away.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])
SOURCES = Path(__file__).parent
STAMP = SOURCES / "__pycache__" / "kernels.stamp"


def kernel(function: Function) -> Function:
    """Compile a function when it is first called, and keep the code on disk."""
    drop_stale_code()
    compiled: Function = njit(cache=True, nogil=True)(function)  # the control loop ticks beside it
    return compiled


@cache
def drop_stale_code() -> None:
    """Delete cached code of the package if any of its sources differs from when it was written."""
    now = _digest(sorted(SOURCES.rglob("*.py")))
    try:
        if STAMP.is_file() and STAMP.read_text(encoding="ascii") == now:
            return
        for old in SOURCES.rglob("__pycache__/*.nb[ic]"):
            old.unlink(missing_ok=True)
        STAMP.parent.mkdir(exist_ok=True)
        STAMP.write_text(now, encoding="ascii")
    except OSError:
        return  # the source tree cannot be written to: Numba caches elsewhere, or not at all


def _digest(files: list[Path]) -> str:
    digest = hashlib.sha256()
    for file in files:
        source = file.read_bytes()
        if b"@kernel" in source:
            digest.update(file.name.encode() + source)
    return digest.hexdigest()
