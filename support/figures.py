# SPDX-License-Identifier: BSD-3-Clause
"""Figures beside their targets: shown in the terminal and written to bench/results/<name>.json."""

from __future__ import annotations

import datetime
import json
import os
import platform
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "bench" / "results"


@dataclass(frozen=True)
class Figure:
    """One measured number."""

    name: str
    value: float
    unit: str
    target: float | None = None  # None: reported without one
    at_most: bool = True  # whether the target is an upper limit
    note: str = ""

    @property
    def is_met(self) -> bool | None:
        """Whether the target is met; None without a target."""
        if self.target is None:
            return None
        return self.value <= self.target if self.at_most else self.value >= self.target


def percentiles(
    name: str, values: Sequence[float], unit: str, targets: dict[int, float] | None = None
) -> list[Figure]:
    """Describe a sample by its p50, p95, p99 and maximum."""
    targets = targets or {}
    found = [
        Figure(f"{name} p{p}", float(np.percentile(values, p)), unit, targets.get(p))
        for p in (50, 95, 99)
    ]
    return [*found, Figure(f"{name} max", float(np.max(values)), unit, targets.get(100))]


def machine() -> dict[str, str | int]:
    """Name the machine, the date and the commit of a measurement."""
    cpu = platform.processor()
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            cpu = line.split(":", 1)[1].strip()
            break
    commit = subprocess.run(
        ["git", "describe", "--always", "--dirty"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    ).stdout.strip()
    return {
        "cpu": cpu,
        "cores": os.cpu_count() or 0,
        "load_at_start": round(os.getloadavg()[0], 2),
        "system": platform.platform(),
        "date": datetime.date.today().isoformat(),
        "commit": commit or "unknown",
    }


def run(name: str, measure: Callable[[], list[Figure]], console: Console) -> list[Figure]:
    """Measure, show and write one set of figures."""
    where = machine()
    console.rule(f"{name}: {where['cpu']}, {where['cores']} cores, load {where['load_at_start']}")
    figures = measure()
    show(figures, console)
    path = RESULTS / f"{name}.json"
    write(path, figures, where)
    console.print(f"written: {path.relative_to(ROOT)}")
    return figures


def show(figures: Sequence[Figure], console: Console) -> None:
    """Print figures beside their targets."""
    table = Table()
    for column in ("figure", "measured", "target", ""):
        table.add_column(column)
    for f in figures:
        sign = "<=" if f.at_most else ">="
        target = "" if f.target is None else f"{sign} {f.target:g} {f.unit}"
        mark = {None: "", True: "[green]met[/green]", False: "[red]missed[/red]"}[f.is_met]
        table.add_row(f"{f.name} {f.note}".strip(), f"{f.value:.4g} {f.unit}", target, mark)
    console.print(table)


def write(path: Path, figures: Sequence[Figure], where: Mapping[str, Any], **more: Any) -> None:
    """Write figures with the machine they were measured on, and what else is given."""
    listed = [{**asdict(f), "met": f.is_met} for f in figures]
    path.parent.mkdir(parents=True, exist_ok=True)
    data = {"machine": where, **more, "figures": listed}
    path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
