# SPDX-License-Identifier: BSD-3-Clause
"""Hours in which nobody gives a command, armed; HOURS=10 for the record."""

from __future__ import annotations

import json
import math
import os
import shutil
from collections import Counter
from pathlib import Path

import soundfile

from bench import voice_noises, voice_sets
from bench.figures import Figure
from bench.voice_bounds import rate_at_most
from bench.voice_run import FOLDER, Row, evaluated
from voice_assist.types import RATE

HOURS = float(os.environ.get("HOURS", "0.2"))
LONGEST = 300.0  # [s] of one piece


def measure() -> list[Figure]:
    """As much of each kind; at most an hour lies on the disk at a time."""
    kinds = tuple(voice_noises.KINDS)
    share = 3600.0 * HOURS / len(kinds)  # [s] of a kind
    pieces = math.ceil(share / LONGEST)
    rows: list[Row] = []
    per_batch = max(1, round(3600.0 / (LONGEST * len(kinds))))
    for first in range(0, pieces, per_batch):
        seeds = range(first, min(first + per_batch, pieces))
        rows += _batch(kinds, share / pieces, seeds)
    figures = [_figure("nothing said: taken", rows, 0.0)]
    figures += [_figure(f"{k}: taken", [r for r in rows if _kind(r) == k]) for k in kinds]
    _write(rows)
    return figures


def _batch(kinds: tuple[str, ...], seconds: float, seeds: range) -> list[Row]:
    folder = voice_sets.CACHE / "nothing"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    names = []
    for kind in kinds:
        for seed in seeds:
            name = f"{kind}_{seed}.wav"
            soundfile.write(folder / name, voice_noises.make(kind, seconds, seed), RATE)
            names.append(name)
    manifest = voice_sets.no_command(folder, names)
    found = evaluated(f"nothing_{seeds.start}", manifest)
    (FOLDER / f"nothing_{seeds.start}.json").unlink()  # nothing.json holds the sum of them
    shutil.rmtree(folder)
    return list(found.rows)


def _kind(row: Row) -> str:
    return Path(row.path).stem.rpartition("_")[0]


def _figure(name: str, rows: list[Row], target: float | None = None) -> Figure:
    taken = Counter(command for row in rows for command in row.taken)
    hours = sum(row.seconds for row in rows) / 3600.0
    which = "".join(f", {command}: {count}" for command, count in taken.items())
    note = f"(in {hours:.2f} h, at most {rate_at_most(taken.total(), hours):.2f}/h{which})"
    return Figure(name, float(taken.total()), "commands", target, note=note)


def _write(rows: list[Row]) -> None:
    fired = [{"sound": Path(r.path).name, "taken": r.taken} for r in rows if r.taken]
    hours = sum(row.seconds for row in rows) / 3600.0
    data = {"hours": hours, "mode": "active", "fired": fired}
    path = FOLDER / "nothing_fired.json"
    path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
