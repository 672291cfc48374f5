# SPDX-License-Identifier: BSD-3-Clause
"""Rows that are kept beside the results, a JSON object per line, each with the key of its code."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def rows_of(path: Path, field: str, key: str) -> list[dict[str, Any]]:
    """Rows of a key, oldest first, without it.

    Args:
        path: May be missing.
        field: That holds the key.
        key: Of the code that made the rows asked for; others are left alone.
    """
    if not path.is_file():
        return []
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    return [row for row in rows if row.pop(field) == key]
