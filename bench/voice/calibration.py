# SPDX-License-Identifier: BSD-3-Clause
"""Whether a confidence of 0.9 is right nine times in ten; curves for it, and limits by risk.

Every decision whose words are a command's is a claim: these words were said. The claims are those
of `voice.trials`, `voice.near` and `voice.armed`. Measured is how far their confidence is from the
share that was right, with a plot.

The evidence for a claim (nats) becomes a probability by a logistic curve (`confidence` of
recognizer.yaml). It is fitted here to claims of one half of the voices and judged on the other. A
claim is worth taking where p * miss > (1 - p) * false, so the least confidence of a command is
false / (false + miss). The costs below are the only judgement in it. The curves are printed for
recognizer.yaml; the limits are for commands.yaml.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from bench.common import resumable
from bench.common.part import HUMAN
from bench.voice import trials as voice_trials
from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.material.mixing import chunks
from bench.voice.no_commands import armed, near_misses
from bench.voice.outcomes import motions
from bench.voice.trials import THIN
from support.figures import Figure
from voice_assist.config import load_voice_config
from voice_assist.config.calibration import Calibration, log_odds

mpl.use("Agg")
import matplotlib.pyplot as plt

FULL = 9642  # claims, when all parts were measured whole
BINS = 10
KINDS = ("stop by the recogniser", "stop by the spotter", "motion", "other")
# Harm of a command that nobody gave, in refusals of one that somebody gave. A motion can tear, and
# "tense" grasps what nobody holds yet, where the others change what is held; a wrong "terminate"
# ends what "hey robot" begins again; a wrong "hey robot" moves nothing by itself.
FALSE = {"motion": 9.0, "tense": 16.0, "terminate": 1.0, "hey robot": 0.5}
SOURCES = ("transcript", "scores", "spotter")  # of evidence, as in recognizer.yaml
LIMIT = 0.9999  # beyond it a confidence was rounded, and says only that the evidence was strong
MAX_EVIDENCES = (2.0, 4.0, 6.0, 8.0, 12.0, 1000.0)  # [nat] where a curve may become level
MIN_SLOPE = 0.05  # [1/nat] less is what chance makes of few claims


@dataclass(frozen=True)
class VoicedClaim:
    """A decision whose words were a command's."""

    command: str
    source: str  # one of SOURCES
    evidence: float  # [nat]
    confidence: float  # by the configured curves
    is_right: bool
    voice: str

    @property
    def kind(self) -> str:
        """One of KINDS."""
        if self.source == "spotter":
            return KINDS[1]
        if self.source == "transcript":
            return KINDS[0]
        return KINDS[2] if self.command in motions() else KINDS[3]


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
    """Error of the confidence, of all claims and of each kind; then of fitted curves."""
    claims = claims_of(_records())
    human = [c for c in claims if c.voice.startswith(HUMAN)]
    synthetic = [c for c in claims if not c.voice.startswith(HUMAN)]
    groups = {"all": claims, "synthetic": synthetic, "human": human}
    groups |= {kind: [c for c in claims if c.kind == kind] for kind in KINDS}
    figures, curves = [], {}
    for name, some in groups.items():
        if some:
            curve = reliability([c.confidence for c in some], [c.is_right for c in some])
            note = f"({sum(c.is_right for c in some)} right of {len(some)} claims)"
            target = 0.03 if name == "all" else None
            figures.append(Figure(f"calibration error, {name}", curve.error, "", target, note=note))
            curves[name] = curve
    _write(curves, len(claims))
    return [resumable.measured(len(claims), "claims", FULL), *figures, *_fitted(claims)]


def _fitted(claims: Sequence[VoicedClaim]) -> list[Figure]:
    """Error in voices that the curves were not fitted to, before and after; limits by risk."""
    fitted, judged = halves(claims)
    curves: dict[str, Calibration] = {}
    for source in SOURCES:
        some = [c for c in fitted if c.source == source]
        if len({c.is_right for c in some}) < 2:
            continue
        curves[source] = fit(some)
        print(f"  {source}: {curves[source]}")
    known = [c for c in judged if c.source in curves]
    if not known:
        return []
    right, before = [c.is_right for c in known], [c.confidence for c in known]
    after = [curves[c.source](c.evidence) for c in known]
    figures = [
        Figure("other half, as configured", reliability(before, right).error, ""),
        Figure("other half, as fitted", reliability(after, right).error, "", 0.03),
    ]
    for command in sorted({c.command for c in claims}):
        figures += _of_command(command, [c for c in claims if c.command == command], curves)
    return figures


def claims_of(records: Iterable[SceneRecord]) -> list[VoicedClaim]:
    """All claims of scenes; right where the scene says the command.

    Their evidence is found back from their confidence, so it ends where the configured curve is
    level: to try a larger `max_evidence` than the configured one, measure with a larger one first.
    """
    worth = load_voice_config().recognizer.confidence
    halts = {c.phrase for c in load_voice_config().commands.commands if c.is_halt}
    found = []
    for record in records:
        voice = f"{record.label['engine']}:{record.label['voice']}"
        for one in record.heard.said:
            if not one.command:
                continue
            source = "spotter" if one.origin == "spotter" else "scores"
            source = "transcript" if one.command in halts and source == "scores" else source
            sure = min(max(one.confidence, 1.0 - LIMIT), LIMIT)
            curve: Calibration = getattr(worth, source)
            evidence = (log_odds(sure) - curve.offset) / curve.slope
            is_right = one.command == record.label["text"]
            found.append(
                VoicedClaim(one.command, source, evidence, one.confidence, is_right, voice)
            )
    return found


def halves(claims: Sequence[VoicedClaim]) -> tuple[list[VoicedClaim], list[VoicedClaim]]:
    """Claims of one half of the voices, chosen by a digest of their names, and of the other."""
    first = {v for v in {c.voice for c in claims} if hashlib.sha256(v.encode()).digest()[0] % 2}
    return [c for c in claims if c.voice in first], [c for c in claims if c.voice not in first]


def fit(claims: Sequence[VoicedClaim]) -> Calibration:
    """The curve of greatest likelihood, with the softened targets of Platt (1999, eq. 12).

    Args:
        claims: Some right and some wrong.
    """
    evidence = np.array([c.evidence for c in claims])
    right = np.array([c.is_right for c in claims])
    wanted = np.where(right, (right.sum() + 1) / (right.sum() + 2), 1 / ((~right).sum() + 2))

    def loss(curve: NDArray[np.float64], maximum: float) -> float:
        odds = (MIN_SLOPE + np.exp(curve[0])) * np.minimum(evidence, maximum) + curve[1]
        return float(np.sum(np.logaddexp(0.0, odds) - wanted * odds))

    start = np.array([-1.0, 0.0])
    tried = {
        maximum: minimize(loss, start, (maximum,), method="Nelder-Mead")
        for maximum in MAX_EVIDENCES
    }
    maximum = min(MAX_EVIDENCES, key=lambda one: tried[one].fun)
    slope, offset = tried[maximum].x
    slope = MIN_SLOPE + float(np.exp(slope))
    return Calibration(slope=round(slope, 3), offset=round(float(offset), 2), max_evidence=maximum)


def min_confidence(command: str) -> float:
    """Confidence from which a command is worth taking."""
    harm = FALSE.get(command, FALSE["motion"] if command in motions() else 1.0)
    return harm / (1.0 + harm)


def _of_command(
    command: str, claims: Sequence[VoicedClaim], curves: Mapping[str, Calibration]
) -> list[Figure]:
    """What a threshold by risk keeps of right and of wrong claims; of halts nothing is chosen."""
    if load_voice_config().commands.get(command).is_halt:
        return []
    limit, some = min_confidence(command), [c for c in claims if c.source in curves]
    kept = [c for c in some if curves[c.source](c.evidence) >= limit]
    right, wrong = (sum(c.is_right is side for c in some) for side in (True, False))
    right_kept, wrong_kept = (sum(c.is_right is side for c in kept) for side in (True, False))
    note = f"(keeps {right_kept} of {right} right claims and {wrong_kept} of {wrong} wrong ones)"
    return [Figure(f"{command}: least confidence by risk", limit, "", note=note)]


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


def _write(curves: Mapping[str, Reliability], claims: int) -> None:
    data = {
        name: {
            "error": curve.error,
            "confidence": curve.confidence.tolist(),
            "right": curve.right.tolist(),
            "count": curve.count.tolist(),
        }
        for name, curve in curves.items()
    }
    folder = resumable.place("voice/calibration_bins.json", claims, FULL)
    resumable.write_details("voice/calibration_bins.json", claims, data, FULL)
    shown = {name: curve for name, curve in curves.items() if name in ("all", *KINDS)}
    draw(shown, folder / "voice" / "reliability.png")


def _records() -> list[SceneRecord]:
    """What the three parts have kept.

    Raises:
        ValueError: One has kept nothing.
    """
    trials = {name: chunks(some) for name, some in voice_trials.conditions(THIN).items() if some}
    near = [r for records in near_misses.measured().values() for r in records]
    found = {
        "voice.trials": [r for rs in pieces.measured("trials", trials).values() for r in rs],
        "voice.near": [r for r in near if not near_misses.is_same(r)],
        "voice.armed": armed.measured(),
    }
    if lacking := [part for part, records in found.items() if not records]:
        raise ValueError(f"{', '.join(lacking)}: nothing is kept; measure that first")
    return [record for records in found.values() for record in records]
