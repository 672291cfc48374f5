# SPDX-License-Identifier: BSD-3-Clause
"""Files that training keeps."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def write_arrays(path: Path, **arrays: NDArray[np.generic]) -> None:
    """Write arrays by name, all or nothing; the folder is made where it is missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(f".{os.getpid()}.npz")  # another program may write the same
    np.savez(temporary, **arrays)  # type: ignore[arg-type]
    temporary.replace(path)


def write_json(path: Path, content: object) -> None:
    """Write JSON, all or nothing; the folder is made where it is missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(f".{os.getpid()}.json")
    temporary.write_text(json.dumps(content), encoding="utf-8")
    temporary.replace(path)
