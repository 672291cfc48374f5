# SPDX-License-Identifier: BSD-3-Clause
"""Curves fitted to claims, and thresholds by risk."""

from __future__ import annotations

import numpy as np
import pytest

from bench.voice.calibration import KINDS, VoicedClaim, claims_of, fit, halves, min_confidence
from tests.unit.bench.voice.test_outcomes import record, said
from voice_assist.config import load_voice_config
from voice_assist.config.calibration import log_odds, logistic


def _claims(slope: float, offset: float, count: int = 4000) -> list[VoicedClaim]:
    rng = np.random.default_rng(2)
    found = []
    for evidence in rng.normal(0.0, 4.0, count):
        is_right = bool(rng.random() < logistic(slope * evidence + offset))
        found.append(VoicedClaim("tense", "scores", float(evidence), 0.5, is_right, "espeak:a"))
    return found


@pytest.mark.parametrize(("slope", "offset"), [(0.25, 0.0), (0.8, 1.5), (1.5, -2.0)])
def test_a_curve_is_found_again_from_what_it_drew(slope: float, offset: float) -> None:
    found = fit(_claims(slope, offset))
    assert found.slope == pytest.approx(slope, rel=0.12)
    assert found.offset == pytest.approx(offset, abs=0.2)


def test_a_dangerous_command_needs_more_than_one_that_moves_nothing() -> None:
    limits = [min_confidence(c) for c in ("hey robot", "terminate", "pull more", "release")]
    assert limits[0] < limits[1] < limits[2] == limits[3] < 1.0


def test_claims_are_right_where_the_words_were_said_and_keep_what_was_refused() -> None:
    worth = load_voice_config().recognizer.confidence
    found = claims_of(
        [
            record("tense", said("tense", confidence=0.8)),
            record("tents", said("tense", confidence=0.3, is_taken=False), said("")),
            record("stop", said("stop"), said("stop", confidence=0.7, origin="spotter")),
        ]
    )
    assert [(c.command, c.source, c.is_right) for c in found] == [
        ("tense", "scores", True),
        ("tense", "scores", False),
        ("stop", "transcript", True),
        ("stop", "spotter", True),
    ]
    assert [c.kind for c in found] == [KINDS[2], KINDS[2], KINDS[0], KINDS[1]]
    curve = worth.scores
    assert found[0].evidence == pytest.approx((log_odds(0.8) - curve.offset) / curve.slope)


def test_halves_share_no_voice() -> None:
    claims = [VoicedClaim("stop", "scores", 1.0, 0.5, True, f"espeak:{i}") for i in range(40)] * 2
    first, second = halves(claims)
    assert first and second and len(first) + len(second) == len(claims)
    assert not {c.voice for c in first} & {c.voice for c in second}
