# SPDX-License-Identifier: BSD-3-Clause
"""Results on file, so that a part of a run never takes the place of a whole one.

In the environment: RESULTS=folder of the repository to write to instead of bench/results, to try;
FORCE=1 writes whatever is on file.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from support import figures
from support.figures import ROOT, Figure

PLACE = ROOT / os.environ.get("RESULTS", "bench/results")
ASIDE = ROOT / ".cache" / "bench" / "partial"  # for results that rest on less than those on file
MEASURED = "measured"  # figure that says on how much a result rests


def measured(amount: float, unit: str, full: float) -> Figure:
    """On how much a result rests; the first figure of a part that can be done in part."""
    return Figure(MEASURED, amount, unit, full, at_most=False)


def kept(name: str, measure: Callable[[], list[Figure]]) -> Callable[[], list[Figure]]:
    """Measure, and choose the place where `support.figures.run` shall write.

    Args:
        name: Of the part.
        measure: Gives its figures.
    """

    def measure_and_choose() -> list[Figure]:
        figures.RESULTS = PLACE
        found = measure()
        figures.RESULTS = place(f"voice/{name}.json", _amount(found))
        return found

    return measure_and_choose


def place(name: str, amount: float | None) -> Path:
    """Folder for a result: aside, if what is on file rests on more.

    Args:
        name: Of the file in that folder.
        amount: On which the new result rests; None: it is always whole.
    """
    path = PLACE / name
    if amount is None or os.environ.get("FORCE") or not path.is_file():
        return PLACE
    before = _on_file(json.loads(path.read_text(encoding="utf-8")))
    if before is None or amount >= before:
        return PLACE
    print(f"{name} on file rests on {before:g}, this run on {amount:g}: written aside; FORCE=1")
    return ASIDE


def write_details(name: str, amount: float, data: Mapping[str, Any]) -> None:
    """Write what lies behind the figures of a part.

    Args:
        name: Of the file, without its ending.
        amount: On which it rests.
        data: For JSON.
    """
    file = f"voice/{name}.json"
    path = place(file, amount) / file
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({MEASURED: amount, **data}, indent=1)
    path.write_text(text + "\n", encoding="utf-8")


def _amount(found: Sequence[Figure]) -> float | None:
    return next((f.value for f in found if f.name == MEASURED), None)


def _on_file(data: Mapping[str, Any]) -> float | None:
    if MEASURED in data:
        return float(data[MEASURED])
    values = (f["value"] for f in data.get("figures", ()) if f["name"] == MEASURED)
    return next(values, None)
