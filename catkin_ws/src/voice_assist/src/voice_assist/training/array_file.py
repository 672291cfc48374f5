# SPDX-License-Identifier: BSD-3-Clause
"""Files that training keeps."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from typed_config import replacing


def write_arrays(path: Path, **arrays: NDArray[np.generic]) -> None:
    """Write arrays by name, all or nothing; the folder is made where it is missing."""
    with replacing(path, ".npz") as temporary:
        np.savez(temporary, **arrays)  # type: ignore[arg-type]


def write_json(path: Path, content: object) -> None:
    """Write JSON, all or nothing; the folder is made where it is missing."""
    with replacing(path, ".json") as temporary:
        temporary.write_text(json.dumps(content), encoding="utf-8")
