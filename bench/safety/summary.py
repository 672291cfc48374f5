# SPDX-License-Identifier: BSD-3-Clause
"""Puts the results of the parts together, as they lie in their files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from support.figures import Figure


def gather(folder: Path, parts: Sequence[str]) -> list[Figure]:
    """Figures of all parts; a part that was never measured misses a target.

    Args:
        folder: With one file for each part that was measured.
        parts: Their names.
    """
    found: list[Figure] = []
    for part in parts:
        path = folder / f"{part}.json"
        if path.is_file():
            found += _of(part, json.loads(path.read_text(encoding="utf-8")))
        else:
            found.append(_measured(part, 0.0, "(never)"))
    return found


def _of(part: str, result: dict[str, Any]) -> list[Figure]:
    where = result["machine"]
    words = f"({where['date']}, {where['commit']}, load {where['load_at_start']})"
    figures = [_measured(part, 1.0, words)]
    for fields in result["figures"]:
        kept = {key: value for key, value in fields.items() if key != "met"}
        figures.append(Figure(**{**kept, "name": f"{part}: {kept['name']}"}))
    return figures


def _measured(part: str, value: float, words: str) -> Figure:
    return Figure(f"{part}: was measured", value, "", 1.0, at_most=False, note=words)
