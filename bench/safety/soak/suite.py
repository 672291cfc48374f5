# SPDX-License-Identifier: BSD-3-Clause
"""A day of commands, talk and faults in process: does an invariant ever fail, does memory grow?

`HOURS=24 JOBS=2 make bench ONLY=safety.soak` is the whole of it; without HOURS it is 24. Pieces of
ten minutes of session time are kept under .cache/bench/safety, so that a run that was interrupted
goes on; MINUTES=30 begins none after half an hour. The key of the folder is made of the code and
the settings, so that a change of either begins anew.
"""

from __future__ import annotations

import json
import logging
import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bench.common import resumable
from bench.common.resumable import code, digest
from bench.safety.soak import session
from bench.safety.soak.check import SHARE
from bench.safety.soak.session import Stretch, carried_out
from support.figures import ROOT, Figure

FULL = 24.0  # [h]
HOURS = float(os.environ.get("HOURS", str(FULL)))
PIECE = 600.0  # [s] of session time
PACKAGES = ("rst_control", "voice_assist")
GROWTH = 2.0  # [MiB] in an hour of session time that is borne
FAMILIES = ("RCM", "tension", "joint speed", "joint acceleration", "joint limits", "mode")
Report = dict[str, Any]


def measure() -> list[Figure]:
    """Carry out what is missing, and sum up all that there is."""
    stretches = [Stretch(seed, PIECE) for seed in range(round(3600.0 * HOURS / PIECE) or 1)]
    reports = carried(stretches, resumable.CACHE / "safety" / identity())
    if not reports:
        raise RuntimeError(f"no piece was carried out within MINUTES={resumable.MINUTES:g}")
    return summary(reports)


def identity() -> str:
    """Key of all that decides what happens: code and settings of controller, voice and soak."""
    own = [p.read_bytes() for p in sorted(Path(session.__file__).parent.glob("*.py"))]
    return digest([code(_source(name)) for name in PACKAGES], [_settings(n) for n in PACKAGES], own)


def _source(package: str) -> Path:
    """Its modules; not `__file__`, which in a catkin workspace is that of a relay."""
    return ROOT / "catkin_ws" / "src" / package / "src" / package


def _settings(package: str) -> list[bytes]:
    folder = ROOT / "catkin_ws" / "src" / package / "config"
    return [path.read_bytes() for path in sorted(folder.glob("*.yaml"))]


def carried(stretches: Sequence[Stretch], folder: Path) -> list[Report]:
    """Reports of the stretches that are there, after those that were missing have been done."""
    jobs = [(one, folder / f"{one.seed}_{one.seconds:g}.json") for one in stretches]
    missing = sum(not path.is_file() for _, path in jobs)
    print(f"soak: {missing} of {len(jobs)} pieces to do, kept in {folder}", flush=True)
    with resumable.pool(resumable.JOBS, _quieten) as pool:
        paths = list(resumable.carried_out("soak", jobs, carried_out, pool))
    return [json.loads(path.read_text(encoding="utf-8")) for path in paths]


def _quieten() -> None:
    logging.disable(logging.CRITICAL)  # every error of the soak's making would be logged


def summary(reports: Sequence[Report]) -> list[Figure]:
    """Figures of all pieces together."""
    hours = sum(report["seconds"] for report in reports) / 3600.0
    counts: Counter[str] = sum((Counter(r["counts"]) for r in reports), Counter())
    broken: Counter[str] = sum((Counter(r["violations"]) for r in reports), Counter())
    ticks = sum(report["ticks"] for report in reports)
    for kind, count in broken.most_common():
        print(f"soak: {count} times {kind}", flush=True)
    said = sum(n for name, n in counts.items() if name.startswith(("say:", "hand:")))
    faults = sum(n for name, n in counts.items() if name.startswith("fault:"))
    note = (
        f"({ticks} ticks; {said} commands, {counts['talk:']} times talk, {counts['stop:']} stops, "
        f"{faults} faults; {counts['event: motion_started']} motions)"
    )
    return [
        resumable.measured(hours, "h", FULL),
        Figure("violations of any invariant", broken.total(), "", 0.0, note=note),
        *(Figure(f"violations: {name}", of(broken, name), "", 0.0) for name in FAMILIES),
        Figure(
            "violations: others", others(broken), "", 0.0, note="(stop, recording, talk, error)"
        ),
        *_extremes(reports),
        *_costs(reports),
    ]


def of(broken: Counter[str], family: str) -> int:
    """Violations of one family."""
    return sum(count for kind, count in broken.items() if kind.startswith(f"{family}:"))


def others(broken: Counter[str]) -> int:
    """Violations of no family."""
    return broken.total() - sum(of(broken, family) for family in FAMILIES)


def _extremes(reports: Sequence[Report]) -> list[Figure]:
    def largest(name: str) -> float:
        return float(max(report["extremes"][name] for report in reports))

    return [
        Figure("RCM error of the true shaft, max", largest("rcm") * 1e6, "um", 1000.0),
        Figure("RCM error of set-points in motion, max", largest("planned_rcm") * 1e6, "um"),
        Figure("true tension, max", largest("tension"), "N", 2.4),
        Figure("set-point speed over its limit, max", largest("speed"), "", 1.0),
        Figure(
            "set-point acceleration over its limit, max", largest("acceleration"), "", 1.0 + SHARE
        ),
        Figure("stop to rest, max", largest("stop"), "s", note="(arm and jaws)"),
    ]


def _costs(reports: Sequence[Report]) -> list[Figure]:
    """Memory: of pieces that began in a process which had carried out another one before."""
    later = [r for r in reports if r["is_later"]]
    growth = [(r["rss_after"] - r["rss_before"]) * 3600.0 / r["seconds"] for r in later]
    seconds, cpu = (sum(r[name] for r in reports) for name in ("seconds", "cpu"))
    note = f"({len(later)} pieces that were not their process's first)"
    return [
        Figure(
            "memory growth, mean",
            sum(growth) / len(growth) if growth else 0.0,
            "MiB/h of session",
            GROWTH if growth else None,
            note=note,
        ),
        Figure("memory at the end, max", max(r["rss_after"] for r in reports), "MiB"),
        Figure("session time over processor time", seconds / cpu, "times"),
    ]
