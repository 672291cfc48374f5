# SPDX-License-Identifier: BSD-3-Clause
"""Files that training keeps."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def write_arrays(path: Path, **arrays: NDArray[np.generic]) -> None:
    """Write arrays by name, all or nothing; the folder is made where it is missing."""
    with replacing(path, ".npz") as temporary:
        np.savez(temporary, **arrays)  # type: ignore[arg-type]


def write_json(path: Path, content: object) -> None:
    """Write JSON, all or nothing; the folder is made where it is missing."""
    with replacing(path, ".json") as temporary:
        temporary.write_text(json.dumps(content), encoding="utf-8")


@contextmanager
def replacing(path: Path, suffix: str) -> Iterator[Path]:
    """A file to write beside another one, whose place it then takes; no error leaves it there.

    Args:
        path: To be replaced; its folder is made where it is missing.
        suffix: Of the file to write.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(f".{os.getpid()}{suffix}")  # another program may write the same
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
