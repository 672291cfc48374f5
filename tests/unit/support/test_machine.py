# SPDX-License-Identifier: BSD-3-Clause
"""A machine that is too slow to hear is named so; the time of others is not judged here."""

import re

from support.machine import ALLOWED, obstacle_of, pass_time


def test_a_slow_machine_is_named_with_its_time_and_what_is_allowed():
    words = obstacle_of(0.0712)
    assert re.search(r"too slow to hear .* takes 71 ms, allowed 50 ms$", words)


def test_one_that_is_quick_enough_is_no_obstacle():
    assert obstacle_of(ALLOWED) == ""


def test_the_time_is_that_of_arithmetic():
    assert 0.0 < pass_time() < 60.0
