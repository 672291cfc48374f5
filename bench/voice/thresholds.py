# SPDX-License-Identifier: BSD-3-Clause
"""Fit what a confidence means, and choose the least one of each command by risk.

Every decision is a claim: these words were said. The evidence for it (nats) becomes a probability
by a logistic curve (`confidence` of recognizer.yaml), fitted here to claims of one half of the
voices and judged on the other half. A claim is worth taking where the harm that it may do is
outweighed: p * miss > (1 - p) * false, so the least confidence of a command is
false / (false + miss). The costs below are the only judgement in it. Prints the curves for
recognizer.yaml; the limits are for commands.yaml.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from bench.voice import armed, near_misses
from bench.voice import trials as voice_trials
from bench.voice.calibration import reliability
from bench.voice.evaluate_once import THIN
from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.material.mixing import chunks
from bench.voice.outcomes import motions
from support.figures import Figure
from voice_assist.config import load_voice_config
from voice_assist.config.calibration import Calibration, log_odds

# Harm of a command that nobody gave, in refusals of one that somebody gave. A motion can tear, and
# "tense" grasps what nobody holds yet, where the others change what is held; a wrong "terminate"
# ends what "hey robot" begins again; a wrong "hey robot" moves nothing by itself.
FALSE = {"motion": 4.0, "tense": 16.0, "terminate": 1.0, "hey robot": 0.5}
SOURCES = ("transcript", "scores", "spotter")  # of evidence, as in recognizer.yaml
LIMIT = 0.9999  # beyond it a confidence was rounded, and says only that the evidence was strong
MOST = (2.0, 4.0, 6.0, 8.0, 12.0, 1000.0)  # [nat] where a curve may become level
LEAST_SLOPE = 0.05  # [1/nat] less is what chance makes of few claims


@dataclass(frozen=True)
class VoicedClaim:
    """A decision whose words were a command's."""

    command: str
    source: str  # one of SOURCES
    evidence: float  # [nat]
    confidence: float  # by the curves in force
    is_right: bool
    voice: str


def measure() -> list[Figure]:
    """Error of the confidence in voices that the curves were not fitted to, before and after."""
    claims = claims_of(_records())
    fitted, judged = halves(claims)
    figures = [Figure("claims", len(claims), "", at_most=False)]
    curves = {}
    for source in SOURCES:
        some = [c for c in fitted if c.source == source]
        if len({c.is_right for c in some}) < 2:
            continue
        curves[source] = fit(some)
        print(f"  {source}: {curves[source]}")
    after = [curves[c.source](c.evidence) for c in judged if c.source in curves]
    right = [c.is_right for c in judged if c.source in curves]
    before = [c.confidence for c in judged if c.source in curves]
    figures.append(Figure("calibration error, as configured", _error(before, right), ""))
    figures.append(Figure("calibration error, as fitted", _error(after, right), "", 0.03))
    for command in sorted({c.command for c in claims}):
        figures += _of_command(command, [c for c in claims if c.command == command], curves)
    return figures


def claims_of(records: Iterable[SceneRecord]) -> list[VoicedClaim]:
    """All claims of scenes; right where the scene says the command.

    Their evidence is found back from their confidence, so it ends where the curve in force is
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

    def loss(curve: NDArray[np.float64], most: float) -> float:
        odds = (LEAST_SLOPE + np.exp(curve[0])) * np.minimum(evidence, most) + curve[1]
        return float(np.sum(np.logaddexp(0.0, odds) - wanted * odds))

    start = np.array([-1.0, 0.0])
    tried = {most: minimize(loss, start, (most,), method="Nelder-Mead") for most in MOST}
    most = min(MOST, key=lambda one: tried[one].fun)
    slope, offset = tried[most].x
    slope = LEAST_SLOPE + float(np.exp(slope))
    return Calibration(slope=round(slope, 3), offset=round(float(offset), 2), max_evidence=most)


def least(command: str) -> float:
    """Confidence from which a command is worth taking."""
    harm = FALSE.get(command, FALSE["motion"] if command in motions() else 1.0)
    return harm / (1.0 + harm)


def _of_command(
    command: str, claims: Sequence[VoicedClaim], curves: Mapping[str, Calibration]
) -> list[Figure]:
    """What a threshold by risk keeps of right and of wrong claims; of halts nothing is chosen."""
    if load_voice_config().commands.get(command).is_halt:
        return []
    limit, some = least(command), [c for c in claims if c.source in curves]
    kept = [c for c in some if curves[c.source](c.evidence) >= limit]
    right, wrong = (sum(c.is_right is side for c in some) for side in (True, False))
    right_kept, wrong_kept = (sum(c.is_right is side for c in kept) for side in (True, False))
    note = f"(keeps {right_kept} of {right} right claims and {wrong_kept} of {wrong} wrong ones)"
    return [Figure(f"{command}: least confidence by risk", limit, "", note=note)]


def _error(confidence: Sequence[float], right: Sequence[bool]) -> float:
    return reliability(confidence, right).error


def _records() -> list[SceneRecord]:
    found: list[SceneRecord] = []
    trials = {name: chunks(some) for name, some in voice_trials.conditions(THIN).items() if some}
    for records in pieces.measured("trials", trials).values():
        found += records
    for records in near_misses.measured().values():
        found += [r for r in records if not near_misses.is_same(r)]
    return found + armed.measured()
