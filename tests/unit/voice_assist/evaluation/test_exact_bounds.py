# SPDX-License-Identifier: BSD-3-Clause
import pytest

from voice_assist.evaluation.exact_bounds import rate_at_most, share_at_most


def test_bounds_are_those_of_clopper_pearson_and_garwood():
    assert share_at_most(0, 3) == pytest.approx(1.0 - 0.05 ** (1.0 / 3.0))
    assert share_at_most(3, 3) == 1.0
    assert rate_at_most(0, 1.0) == pytest.approx(2.996, abs=0.001)
    assert rate_at_most(1, 0.0) == float("inf")
