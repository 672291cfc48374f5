# SPDX-License-Identifier: BSD-3-Clause
"""Accuracy, false commands and latency; synthetic and human voices apart."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bench.voice import evaluate_once
from bench.voice.outcomes import rate_at_most
from session_log.report.bounds import at_least
from support.figures import Figure


def measure() -> list[Figure]:
    """Evaluate each set through the whole streaming pipeline."""
    quiet = evaluate_once.quiet().figures
    figures = _accuracy("synthetic, quiet", quiet, 0.97)
    figures += _latency(quiet)
    figures.append(Figure("near misses taken", _rate(quiet), "of all", note="(synthetic)"))
    figures.append(Figure("real-time factor", quiet["real_time_factor"], "", 0.5))
    for snr in (10, 0):
        figures += _accuracy(f"synthetic, {snr} dB", evaluate_once.noisy(snr).figures)
    return figures + _people()


def _people() -> list[Figure]:
    stop, words, talk = (
        evaluate_once.human_stop(),
        evaluate_once.human_words(),
        evaluate_once.human_talk(),
    )
    if stop is None or words is None or talk is None:
        print("no human speech in ../shared/speech: human figures left out")
        return []
    figures = _accuracy("human stop", stop.figures, 0.95)
    for name, found in (("human words", words), ("human talk", talk)):
        negatives = found.figures["negatives"]
        for mode in ("stop", "motion"):
            taken, hours = _taken(negatives["by_command"], mode), negatives["hours"]
            bound = rate_at_most(taken, hours)
            note = f"({taken} in {hours:.2f} h, armed; at most {bound:.2f} with 95 %)"
            figures.append(Figure(f"{name}: false {mode}", taken / hours, "per h", note=note))
    return figures


def _taken(by_command: Mapping[str, int], mode: str) -> int:
    others = ("hey robot", "terminate", "stop")
    if mode == "stop":
        return by_command.get("stop", 0)
    return sum(n for command, n in by_command.items() if command not in others)


def _accuracy(name: str, found: Mapping[str, Any], target: float | None = None) -> list[Figure]:
    n = sum(entry["n"] for entry in found["commands"].values())
    right = sum(entry["correct"] for entry in found["commands"].values())
    wrong = sum(sum(e["confused"].values()) for e in found["commands"].values())
    note = f"({right} of {n}, at least {at_least(right, n):.3f} with 95 %)"
    return [
        Figure(f"{name}: right", right / n, "of all", target, at_most=False, note=note),
        Figure(f"{name}: another command", wrong / n, "of all", note=f"({wrong} of {n})"),
    ]


def _latency(found: Mapping[str, Any]) -> list[Figure]:
    figures = []
    for phrase, times in found["latency_ms"].items():
        if times["p50"] is None:
            continue
        limits = {"p50": 150.0, "p99": 300.0} if phrase == "stop" else {"p50": 250.0, "p95": 500.0}
        for name, value in times.items():
            figures.append(Figure(f"{phrase}: {name}", value, "ms", limits.get(name)))
    return figures


def _rate(found: Mapping[str, Any]) -> float:
    negatives = found["negatives"]
    return float(negatives["accepted"] / max(negatives["n"], 1))
