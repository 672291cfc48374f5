# SPDX-License-Identifier: BSD-3-Clause
"""Readings keep the sender's distance however they arrive, also when a clock is set."""

from __future__ import annotations

import pytest

from rst_control.tension.clock_offset import SentTimes


def test_bunched_messages_stay_as_far_apart_as_they_were_taken() -> None:
    times = SentTimes(0.2)
    taken = [times.of(1e9 + k * 0.025, 5.0 + late) for k, late in enumerate((0.0, 0.09, 0.091))]
    assert taken == pytest.approx([5.0, 5.025, 5.05], abs=1e-6)


@pytest.mark.parametrize("step", [-3600.0, -0.1, 3600.0])
def test_a_clock_that_was_set_begins_anew_at_the_arrival(step: float) -> None:
    times = SentTimes(0.2)
    times.of(1e9, 5.0)
    assert times.of(1e9 + step + 0.025, 5.025) == pytest.approx(5.025, abs=1e-6)
    assert times.of(1e9 + step + 0.050, 5.080) == pytest.approx(5.050, abs=1e-6)
