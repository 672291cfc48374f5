# SPDX-License-Identifier: BSD-3-Clause
"""Evidence and probability."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voice_assist.config.calibration import Calibration, log_odds, logistic

finite = st.floats(-1e6, 1e6)
curve = st.builds(
    Calibration,
    slope=st.floats(0.001, 100.0),
    offset=st.floats(-50.0, 50.0),
    max_evidence=st.floats(-1000.0, 1000.0),
)


@given(curve, finite, finite)
def test_more_evidence_is_never_less_probable(worth: Calibration, one: float, other: float) -> None:
    less, more = sorted((one, other))
    assert 0.0 <= worth(less) <= worth(more) <= 1.0


def test_no_evidence_is_worth_the_offset() -> None:
    assert Calibration(slope=2.0, offset=0.0, max_evidence=9.0)(0.0) == 0.5
    assert Calibration(slope=2.0, offset=math.log(9.0), max_evidence=9.0)(0.0) == pytest.approx(0.9)


@pytest.mark.parametrize(("evidence", "expected"), [(math.inf, 1.0), (-math.inf, 0.0)])
def test_certainty_is_no_error(evidence: float, expected: float) -> None:
    assert Calibration(slope=0.25, offset=3.0, max_evidence=1000.0)(evidence) == pytest.approx(
        expected
    )


@given(st.floats(1e-9, 1.0 - 1e-9))
def test_log_odds_and_logistic_undo_each_other(probability: float) -> None:
    assert logistic(log_odds(probability)) == pytest.approx(probability, rel=1e-6)


@pytest.mark.parametrize("probability", [0.0, 1.0])
def test_rounded_probabilities_have_finite_odds(probability: float) -> None:
    assert math.isfinite(log_odds(probability))


def test_evidence_beyond_its_limit_adds_nothing() -> None:
    worth = Calibration(slope=1.0, offset=0.5, max_evidence=2.0)
    assert worth(1.9) < worth(2.0) == worth(30.0) == worth(math.inf) == logistic(2.5)
