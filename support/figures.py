# SPDX-License-Identifier: BSD-3-Clause
"""Figures beside their targets: shown in the terminal and written to bench/results/<name>.json.

`docs/measured.md` is made from these files by `make figures`.
"""

from __future__ import annotations

import datetime
import json
import math
import os
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from session_log.recording.metadata import machine_facts
from session_log.report import bounds
from support.product_code import HEARING, beside_hearing, identity
from voice_assist.evaluation.exact_bounds import rate_at_most
from voice_assist.pipeline.hang_detection import stolen

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "bench" / "results"
DRAWS = 10_000  # of groups, for a bound
LOW, HIGH = 0.05, 0.95  # quantiles of the draws that are bounds
DECISIONS = RESULTS / "voice" / "decisions.json"  # see bench/voice/hearing/fingerprint.py
FIXED_SESSIONS = RESULTS / "site" / "fixed_sessions.json"  # see bench/site/fixed_sessions.py
SEVERAL = "several"  # in place of the code of a result whose pieces are of different code


@dataclass(frozen=True)
class Figure:
    """One measured number, with all that the page of figures says of it."""

    name: str
    value: float
    unit: str
    target: float | None = None  # None: reported without one
    at_most: bool = True  # whether the target is an upper limit
    note: str = ""  # conditions, such as how many trials
    lower: float | None = None  # bound with 95 %, in the same unit
    upper: float | None = None  # likewise
    voices: str = ""  # "human" or "synthetic"; empty: as its part says

    @property
    def is_met(self) -> bool | None:
        """Whether the target is met; None without a target."""
        return self._reaches(self.value)

    @property
    def is_shown(self) -> bool:
        """Whether the target is met by the bound too, so that more trials would hardly miss it."""
        return bool(self.is_met) and (self.bound is None or bool(self._reaches(self.bound)))

    @property
    def bound(self) -> float | None:
        """The bound that a target is held against; None: there is none."""
        return self.upper if self.at_most else self.lower

    def _reaches(self, value: float) -> bool | None:
        if self.target is None:
            return None
        return value <= self.target if self.at_most else value >= self.target


def share(
    name: str,
    count: int,
    trials: int,
    target: float | None = None,
    at_most: bool = False,
    note: str = "",
    voices: str = "",
    groups: Sequence[tuple[int, int]] = (),
) -> Figure:
    """Share of trials [%] with its exact bound (Clopper and Pearson 1934).

    Args:
        name: Of the figure.
        count: Of the trials.
        trials: At least one.
        target: In per cent.
        at_most: Whether few are good; then the bound is the upper one.
        note: Conditions, beside the counts.
        voices: "human" or "synthetic".
        groups: Counts and trials of each voice, where one voice has several trials. They are then
            no independent ones: the bound is the wider of the exact one and `over_groups`.
    """
    counts = f"{count} of {trials}{note and '; '}{note}"
    bound = (bounds.at_most if at_most else bounds.at_least)(count, trials)
    if len(groups) > 1:
        wider, q = (max, HIGH) if at_most else (min, LOW)
        bound = wider(bound, over_groups(groups, q))
    low, high = (None, 100.0 * bound) if at_most else (100.0 * bound, None)
    value = 100.0 * count / trials
    return Figure(name, value, "%", target, at_most, counts, low, high, voices)


def over_groups(groups: Sequence[tuple[float, int]], q: float) -> float:
    """Bound on a share or a mean of trials in groups, by drawing the groups anew (Efron 1979).

    Args:
        groups: Counts and trials of each; of a mean, sums and trials.
        q: Quantile of the draws.
    """
    counts, trials = np.array(groups, float).T
    drawn = np.random.default_rng(0).integers(len(counts), size=(DRAWS, len(counts)))
    shares = counts[drawn].sum(axis=1) / trials[drawn].sum(axis=1)
    return float(np.quantile(shares, q))


def rate(
    name: str,
    count: int,
    hours: float,
    target: float | None = None,
    note: str = "",
    voices: str = "",
    unique: float | None = None,
) -> Figure:
    """Events per hour with the exact upper bound of a Poisson process (Garwood 1936).

    Args:
        name: Of the figure.
        count: Events.
        hours: Heard [h].
        target: Most events [1/h].
        note: Conditions, beside the counts.
        voices: "human" or "synthetic".
        unique: Length of the recordings [h] that were heard again and again to fill the hours; the
            bound is that of so long a time.
    """
    counts = f"{count} in {hours:.2f} h{note and '; '}{note}"
    repeats = 1.0 if unique is None else max(1.0, hours / unique)
    high = rate_at_most(count / repeats, hours / repeats)
    return Figure(name, count / hours, "per h", target, True, counts, None, high, voices)


def percentiles(
    name: str, values: Sequence[float], unit: str, targets: dict[int, float] | None = None
) -> list[Figure]:
    """Describe a sample by its p50, p95 and p99, with their upper bounds, and its maximum.

    Raises:
        ValueError: There are no values.
    """
    if not len(values):
        raise ValueError(f"{name}: no values, allowed: at least one")
    targets, n = targets or {}, f"n={len(values)}"
    found = []
    for p in (50, 95, 99):
        q = bounds.quantile(values, p / 100.0)
        upper = q.high if math.isfinite(q.high) else None  # too few values have none
        figure = Figure(f"{name} p{p}", q.value, unit, targets.get(p), note=n, upper=upper)
        found.append(figure)
    return [*found, Figure(f"{name} max", float(np.max(values)), unit, targets.get(100), note=n)]


def machine() -> dict[str, str | float]:
    """Name the machine, the date and the commit of a measurement."""
    facts = machine_facts()
    commit = subprocess.run(
        ["git", "describe", "--always", "--dirty"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    ).stdout.strip()
    return {
        "cpu": facts["processor"],
        "cores": os.cpu_count() or 0,
        "load_at_start": round(os.getloadavg()[0], 2),
        "system": facts["system"],
        "date": datetime.date.today().isoformat(),
        "commit": commit or "unknown",
    }


def run(
    name: str,
    measure: Callable[[], list[Figure]],
    console: Console,
    rooms: Sequence[str] = (),
    decisions: str = "",
    is_of_other_code: Callable[[], bool] = lambda: False,
    bench: str = "",
) -> list[Figure]:
    """Measure, show and write one set of figures.

    Args:
        name: Of the file of results, such as "voice/near".
        measure: Gives them.
        console: To show them on.
        rooms: Of the product, which they are figures of; see support/product_code.py.
        decisions: Key of what it decides on fixed clips; empty: these are no figures of that.
        is_of_other_code: Asked afterwards: whether kept pieces of other code were counted, too.
        bench: Digest of the code that measures.
    """
    where, code = machine(), {**keys(rooms, decisions), "bench": bench}
    console.rule(f"{name}: {where['cpu']}, {where['cores']} cores, load {where['load_at_start']}")
    before, began = _stolen(), time.monotonic()
    figures = measure()
    where["stolen"] = round((_stolen() - before) / (time.monotonic() - began), 3)
    if is_of_other_code():
        code["code"] = SEVERAL
    show(figures, console)
    path = RESULTS / f"{name}.json"
    write(path, figures, where, **code)
    console.print(f"written: {path.relative_to(ROOT)}")
    return figures


def _stolen() -> float:
    """How long the host has used one of the processors so far, on average [s]."""
    times = list(stolen().values())
    return sum(times) / max(1, len(times))


def keys(rooms: Sequence[str], decisions: str) -> dict[str, str]:
    """What a result has on file of the code that it is of.

    Args:
        rooms: Of the product; see support/product_code.py.
        decisions: Key of what hearing decides on fixed clips; empty: nothing follows from it.
    """
    code = {"code": identity(rooms)}
    if not decisions:
        return code
    return {**code, "decisions": decisions, "beside_hearing": beside_hearing(rooms)}


def noted(path: Path) -> dict[str, str]:
    """Digests of what was found of versions of the code; none where nothing is noted."""
    found: dict[str, str] = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return found


def decided_now(which: str) -> str:
    """Key of what the present code decides on fixed clips.

    Args:
        which: "rest" or "motion".

    Returns:
        Empty where it is not noted.
    """
    known = noted(DECISIONS)
    return known.get(which, "") if known.get("code") == identity(HEARING) else ""


def moves_alike(lead: str, code: str, now: str) -> bool:
    """Whether two versions of the controller were found to do the same in fixed sessions.

    Args:
        lead: By what the arm is led in these: "set-points" or "velocities".
        code: Digest of the older one.
        now: Of the present one.
    """
    known = noted(FIXED_SESSIONS)
    before = known.get(f"{lead} {code}")
    return before is not None and before == known.get(f"{lead} {now}")


def show(figures: Sequence[Figure], console: Console) -> None:
    """Print figures beside their targets."""
    table = Table()
    for column in ("figure", "measured", "target", ""):
        table.add_column(column)
    for f in figures:
        sign = "<=" if f.at_most else ">="
        target = "" if f.target is None else f"{sign} {f.target:g} {f.unit}"
        mark = {None: "", True: "[green]met[/green]", False: "[red]missed[/red]"}[f.is_met]
        value = f"{f.value:.4g} {f.unit} {interval(f)}".strip()
        table.add_row(f"{f.name} {f.note}".strip(), value, target, mark)
    console.print(table)


def interval(figure: Figure) -> str:
    """Bounds with 95 % in words; empty where there are none."""
    low, high = figure.lower, figure.upper
    if low is not None and high is not None:
        return f"{low:.4g} to {high:.4g}"
    if low is not None:
        return f"at least {low:.4g}"
    return "" if high is None else f"at most {high:.4g}"


def read(path: Path) -> list[Figure]:
    """Figures of a file of results; of older files too, which lack some fields."""
    data = json.loads(path.read_text(encoding="utf-8"))
    known = {field.name for field in fields(Figure)}
    return [Figure(**{k: v for k, v in one.items() if k in known}) for one in data["figures"]]


def write(path: Path, figures: Sequence[Figure], where: Mapping[str, Any], **more: Any) -> None:
    """Write figures with the machine they were measured on, and what else is given."""
    listed = [{**asdict(f), "met": f.is_met} for f in figures]
    path.parent.mkdir(parents=True, exist_ok=True)
    data = {"machine": where, **more, "figures": listed}
    path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
