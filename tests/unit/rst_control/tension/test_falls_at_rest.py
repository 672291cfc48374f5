# SPDX-License-Identifier: BSD-3-Clause
"""What the tension loses at rest: added up over rests, and reckoned with for what lies between."""

import pytest

from rst_control.tension.falls_at_rest import FallsAtRest


def test_falls_of_several_rests_add_up():
    falls = FallsAtRest()
    falls.update((1.0, 0.5), (1.5, 0.45), error=1.0)
    falls.move()
    falls.update((2.0, 0.9), (2.2, 0.87), error=1.0)
    falls.update((2.2, 0.87), (2.5, 0.82), error=1.0)
    assert falls.total == pytest.approx(0.05 + 0.08)


def test_a_fall_that_noise_does_not_explain_is_taken_to_go_on_in_motion():
    falls = FallsAtRest()
    falls.update((1.0, 0.5), (1.5, 0.5), error=0.01)
    falls.move()
    falls.update((3.5, 0.9), (4.0, 0.84), error=0.01)  # 0.1 N/s, for certain
    assert falls.total == pytest.approx(0.06 + 0.1 * 2.0)


def test_tissue_that_recovers_takes_back_what_it_lost_and_no_more():
    falls = FallsAtRest()
    falls.update((1.0, 0.5), (1.5, 0.4), error=1.0)
    falls.move()
    falls.update((2.0, 0.2), (2.5, 0.5), error=1.0)
    assert falls.total == 0.0
    falls.move()
    falls.update((3.0, 0.5), (3.5, 0.45), error=1.0)
    assert falls.total == pytest.approx(0.05)


def test_the_next_grasp_begins_anew():
    falls = FallsAtRest()
    falls.update((1.0, 0.5), (1.5, 0.3), error=0.0)
    falls.forget()
    assert falls.total == 0.0
    falls.update((9.0, 0.5), (9.5, 0.45), error=0.0)
    assert falls.total == pytest.approx(0.05)
