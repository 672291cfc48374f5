# SPDX-License-Identifier: BSD-3-Clause
"""The bridge's heartbeat, BridgeBeat: what the guard takes from this message."""

import numpy as np
import pytest

from rst_control.kinova.brake_plan import LastCourse
from rst_control.ros.kinova.beat import ROWS, beat_message, course_of

COURSE = LastCourse(time=4.0, **{row: np.arange(7.0) + k for k, row in enumerate(ROWS)})


def test_a_course_comes_back_as_it_was_sent():
    found = course_of(beat_message(COURSE, 4.5), 10.0)
    assert found is not None and found.time == 9.5
    for row in ROWS:
        np.testing.assert_array_equal(getattr(found, row), getattr(COURSE, row))


def test_an_arm_that_is_not_led_has_no_course():
    assert course_of(beat_message(None, 4.5), 10.0) is None


@pytest.mark.parametrize("row", ["age", *ROWS])
def test_numbers_that_are_none_say_nothing(row):
    beat = beat_message(COURSE, 4.5)
    bad = float("nan")
    setattr(beat, row, bad if row == "age" else [0.0] * 6 + [bad])
    assert course_of(beat, 10.0) is None
