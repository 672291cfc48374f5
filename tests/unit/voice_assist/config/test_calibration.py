# SPDX-License-Identifier: BSD-3-Clause
"""Evidence and probability."""

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
def test_more_evidence_is_never_less_probable(worth, one, other):
    less, more = sorted((one, other))
    assert 0.0 <= worth(less) <= worth(more) <= 1.0


@pytest.mark.parametrize(
    ("offset", "evidence", "worth"),
    [(0.0, 0.0, 0.5), (math.log(9.0), 0.0, 0.9), (3.0, math.inf, 1.0), (3.0, -math.inf, 0.0)],
)
def test_no_evidence_is_worth_the_offset_and_certainty_is_no_error(offset, evidence, worth):
    curve = Calibration(slope=0.25, offset=offset, max_evidence=1000.0)
    assert curve(evidence) == pytest.approx(worth)


@given(st.floats(1e-9, 1.0 - 1e-9))
def test_log_odds_and_logistic_undo_each_other_and_are_finite(probability):
    assert logistic(log_odds(probability)) == pytest.approx(probability, rel=1e-6)
    assert math.isfinite(log_odds(round(probability)))


def test_evidence_beyond_its_limit_adds_nothing():
    worth = Calibration(slope=1.0, offset=0.5, max_evidence=2.0)
    assert worth(1.9) < worth(2.0) == worth(30.0) == worth(math.inf) == logistic(2.5)
