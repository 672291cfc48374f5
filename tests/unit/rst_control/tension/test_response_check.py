# SPDX-License-Identifier: BSD-3-Clause
from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rst_control.tension.response_check import ResponseCheck

WAY = np.linspace(0.0, 0.03, 1501)


def objection(tension_at, way=WAY):
    answer = ResponseCheck()
    for s in way:
        answer.update(s, tension_at(s))
        if answer.objection:
            return s, answer.objection.words
    return None


@pytest.mark.parametrize("stiffness", [20.0, 80.0, 600.0, 4000.0])
def test_tissue_that_pulls_back_is_not_objected_to(stiffness):
    assert objection(lambda s: min(stiffness * s, 50.0), WAY[: int(2.4 / stiffness / 2e-5)]) is None


@given(st.floats(50.0, 600.0), st.floats(0.0, 0.01))
def test_nor_is_tissue_that_stiffens_after_slack(bend, slack):
    assert objection(lambda s: 0.02 * np.expm1(min(bend * max(0.0, s - slack), 5.0))) is None or (
        bend * (WAY[-1] - slack) > 5.0  # there the law itself stops rising
    )


def test_slack_that_never_ends_is_not_objected_to():
    assert objection(lambda s: 0.0) is None


@pytest.mark.parametrize("stiffness", [80.0, 400.0, 2000.0])
def test_a_tension_that_stays_as_it_was_is_noticed_before_much_more_pull(stiffness):
    froze = 1.0 / stiffness
    way = np.linspace(0.0, 3.0 / stiffness, 1501)
    s, words = objection(lambda s: stiffness * min(s, froze), way)
    assert stiffness * (s - froze) < 0.35
    assert "0.0 mm" not in words or stiffness >= 2000.0
    assert "sensor dead" in words


def test_easing_and_pulling_again_is_not_objected_to():
    way = np.concatenate([WAY[:500], WAY[500:100:-1], WAY[100:500]])
    assert objection(lambda s: 200.0 * s, way) is None
