# SPDX-License-Identifier: BSD-3-Clause
"""Whether a confidence of 0.9 is right nine times in ten; error and reliability plot."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

from bench.voice import evaluate_once, near_misses
from bench.voice.evaluate_once import FOLDER, Evaluated
from support.figures import Figure
from voice_assist.config import load_voice_config

mpl.use("Agg")
import matplotlib.pyplot as plt

BINS = 10
KINDS = ("stop by the recogniser", "stop by the spotter", "motion", "other")


@dataclass(frozen=True)
class Believed:
    """A confidence, and whether it was right."""

    kind: str  # one of KINDS
    voices: str  # "synthetic" or "human"
    confidence: float  # [0, 1]
    is_right: bool


@dataclass(frozen=True, eq=False)
class Reliability:
    """Confidence against correctness in equally wide bins; bins without a claim are left out."""

    confidence: NDArray[np.float64]  # mean of each bin
    right: NDArray[np.float64]  # share of each bin
    count: NDArray[np.int64]

    @property
    def error(self) -> float:
        """Expected calibration error: mean gap of the bins, weighted by their counts."""
        gap = np.abs(self.confidence - self.right)
        return float(np.sum(self.count * gap) / np.sum(self.count))


def reliability(confidence: Sequence[float], is_right: Sequence[bool]) -> Reliability:
    """Bin claims as Guo et al. do ("On calibration of modern neural networks", 2017, eq. 3).

    Args:
        confidence: Of each claim, [0, 1]; at least one.
        is_right: Of each.
    """
    sure, right = np.asarray(confidence, np.float64), np.asarray(is_right, np.float64)
    index = np.minimum((sure * BINS).astype(np.int64), BINS - 1)
    count = np.bincount(index, minlength=BINS)
    used = count > 0
    total_sure = np.bincount(index, sure, BINS)[used]
    total_right = np.bincount(index, right, BINS)[used]
    return Reliability(total_sure / count[used], total_right / count[used], count[used])


def measure() -> list[Figure]:
    """All claims of quiet and noisy commands, near misses and people."""
    synthetic = [
        evaluate_once.quiet(),
        evaluate_once.noisy(10),
        evaluate_once.noisy(0),
        near_misses.near(),
    ]
    human = [evaluate_once.human_stop(), evaluate_once.human_words(), evaluate_once.human_talk()]
    claims = [c for found in synthetic for c in claims_of(found, "synthetic")]
    claims += [c for found in human if found for c in claims_of(found, "human")]
    figures, curves = [], {}
    groups = [("all", claims)]
    groups += [(v, [c for c in claims if c.voices == v]) for v in ("synthetic", "human")]
    groups += [(kind, [c for c in claims if c.kind == kind]) for kind in KINDS]
    for name, some in groups:
        if not some:
            continue
        curve = reliability([c.confidence for c in some], [c.is_right for c in some])
        right = sum(c.is_right for c in some)
        note = f"({right} right of {len(some)} claims)"
        target = 0.03 if name == "all" else None
        figures.append(Figure(f"calibration error, {name}", curve.error, "", target, note=note))
        curves[name] = curve
    _write(curves)
    draw({k: v for k, v in curves.items() if k in ("all", *KINDS)}, FOLDER / "reliability.png")
    return figures


def claims_of(found: Evaluated, voices: str) -> list[Believed]:
    """Decisions whose words are a command's, taken or refused; right where it was said."""
    config = load_voice_config().commands
    claims = []
    for row in found.rows:
        for claim in row.claims:
            command = config.get(claim.command)
            if command.is_halt:
                kind = KINDS[1] if claim.origin == "spotter" else KINDS[0]
            else:
                kind = KINDS[2] if command.is_motion else KINDS[3]
            is_right = claim.command == row.command
            claims.append(Believed(kind, voices, claim.confidence, is_right))
    return claims


def draw(curves: dict[str, Reliability], path: Path) -> None:
    """A panel per kind: share right over confidence, each point with its number of claims."""
    figure, panels = plt.subplots(1, len(curves), figsize=(3.4 * len(curves), 3.9), sharey=True)
    for panel, (name, curve) in zip(np.atleast_1d(panels), curves.items(), strict=True):
        panel.plot([0, 1], [0, 1], color="0.6", linestyle="--", linewidth=1)
        panel.plot(curve.confidence, curve.right, marker="o", color="tab:blue")
        for x, y, n in zip(curve.confidence, curve.right, curve.count, strict=True):
            below = (0, -14) if y > 0.5 else (0, 7)
            panel.annotate(
                str(n), (x, y), below, textcoords="offset points", ha="center", fontsize=8
            )
        panel.set(xlim=(-0.03, 1.05), ylim=(-0.05, 1.08), xlabel="confidence")
        panel.set_title(f"{name}\nn = {curve.count.sum()}, error {curve.error:.3f}", fontsize=10)
        panel.grid(alpha=0.3)
    np.atleast_1d(panels)[0].set_ylabel("share that was right")
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _write(curves: dict[str, Reliability]) -> None:
    data = {
        name: {
            "error": curve.error,
            "confidence": curve.confidence.tolist(),
            "right": curve.right.tolist(),
            "count": curve.count.tolist(),
        }
        for name, curve in curves.items()
    }
    path = FOLDER / "calibration_bins.json"
    path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
