# SPDX-License-Identifier: BSD-3-Clause
"""Accuracy, false commands and latency of the recogniser, by the command that `make evaluate` runs.

Synthetic and human voices are reported apart. Bounds are exact (Clopper and Pearson, one-sided).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from scipy.stats import beta

from bench import voice_sets
from bench.figures import RESULTS, ROOT, Figure

KEEP = bool(os.environ.get("KEEP"))  # use the results that are there, measure the others
THIN = int(os.environ.get("THIN", "3"))  # one clip in so many of noise, words and talk; 1: all


def measure() -> list[Figure]:
    """Evaluate each set through the whole streaming pipeline."""
    commands, noise = voice_sets.synthetic_commands(), voice_sets.theatre()
    quiet = _evaluate("synthetic_quiet", commands)
    figures = _accuracy("synthetic, quiet", quiet, 0.97)
    figures += _latency(quiet)
    figures.append(Figure("near misses taken", _rate(quiet), "of all", note="(synthetic)"))
    figures.append(Figure("real-time factor", quiet["real_time_factor"], "", 0.5))
    for snr in (10, 0):
        noisy = _evaluate(f"synthetic_{snr}dB", voice_sets.synthetic_commands(THIN), noise, snr)
        figures += _accuracy(f"synthetic, {snr} dB", noisy)
    return figures + _people()


def _people() -> list[Figure]:
    stop = voice_sets.people("dev", only="stop")
    words = voice_sets.people("dev", THIN)
    talk = voice_sets.people("false_accept_dev", 2 * THIN)
    if stop is None or words is None or talk is None:
        print("no human speech in ../shared/speech: human figures left out")
        return []
    figures = _accuracy("human stop", _evaluate("human_stop", stop), 0.95)
    for name, manifest in (("human words", words), ("human talk", talk)):
        found = _evaluate(name.replace(" ", "_"), manifest)["negatives"]
        for mode in ("stop", "motion"):
            taken = _taken(found["by_command"], mode)
            note = f"({taken} in {found['hours']:.2f} h, armed)"
            figures.append(
                Figure(f"{name}: false {mode}", taken / found["hours"], "per h", note=note)
            )
    return figures


def _taken(by_command: dict[str, int], mode: str) -> int:
    others = ("hey robot", "terminate", "stop")
    if mode == "stop":
        return by_command.get("stop", 0)
    return sum(n for command, n in by_command.items() if command not in others)


def _evaluate(name: str, manifest: Path, noise: Path | None = None, snr: float = 0.0) -> Any:
    out = RESULTS / "voice" / f"{name}.json"
    out.parent.mkdir(parents=True, exist_ok=True)
    if KEEP and out.is_file():
        return json.loads(out.read_text(encoding="utf-8"))
    command = [sys.executable, "-m", "voice_assist.cli", "evaluate", str(manifest)]
    command += ["--out", str(out)]
    if noise is not None:
        command += ["--noise", str(noise.relative_to(ROOT)), "--snr", str(snr)]
    subprocess.run(command, check=True, cwd=ROOT)
    return json.loads(out.read_text(encoding="utf-8"))


def _accuracy(name: str, found: Any, target: float | None = None) -> list[Figure]:
    n = sum(entry["n"] for entry in found["commands"].values())
    right = sum(entry["correct"] for entry in found["commands"].values())
    wrong = sum(sum(e["confused"].values()) for e in found["commands"].values())
    bound = float(beta.ppf(0.05, right, n - right + 1)) if right else 0.0
    note = f"({right} of {n}, at least {bound:.3f} with 95 %)"
    return [
        Figure(f"{name}: right", right / n, "of all", target, at_most=False, note=note),
        Figure(f"{name}: another command", wrong / n, "of all", note=f"({wrong} of {n})"),
    ]


def _latency(found: Any) -> list[Figure]:
    figures = []
    for phrase, times in found["latency_ms"].items():
        if times["p50"] is None:
            continue
        limits = {"p50": 150.0, "p99": 300.0} if phrase == "stop" else {"p50": 250.0, "p95": 500.0}
        for name, value in times.items():
            figures.append(Figure(f"{phrase}: {name}", value, "ms", limits.get(name)))
    return figures


def _rate(found: Any) -> float:
    negatives = found["negatives"]
    return float(negatives["accepted"] / max(negatives["n"], 1))
