# SPDX-License-Identifier: BSD-3-Clause
"""Push-to-talk: speech counts only if voice counted over all of it."""

import pytest

from voice_assist.audio.talk_gate import EARLY_RELEASE, LATE_PRESS, TalkChange, TalkGate


def gate(*changes):
    made = TalkGate()
    for is_open, time in changes:
        made.update(TalkChange(is_open, time))
    return made


@pytest.mark.parametrize(
    ("changes", "counts"),
    [
        ([], True),  # no news of a gate
        ([(False, 0.0)], False),
        ([(True, 0.0)], True),
        ([(False, 0.0), (True, 9.9)], True),  # pressed, then said
        ([(False, 0.0), (True, 10.0 + 0.9 * LATE_PRESS)], True),
        ([(False, 0.0), (True, 10.0 + 1.1 * LATE_PRESS)], False),  # said, then pressed
        ([(False, 0.0), (True, 9.0), (False, 9.9)], False),  # released, then said
        ([(False, 0.0), (True, 9.0), (False, 12.0 - 0.9 * EARLY_RELEASE)], True),
        ([(False, 0.0), (True, 9.0), (False, 12.0 - 1.1 * EARLY_RELEASE)], False),
        ([(False, 0.0), (True, 9.0), (False, 11.0), (True, 11.1)], False),  # let go in between
        ([(False, 0.0), (True, 12.5)], False),
    ],
)
def test_speech_from_10_to_12_s_counts_if_it_was_open_over_all_of_it(changes, counts):
    assert gate(*changes).was_open(10.0, 12.0) is counts


def test_a_short_word_in_a_short_press_counts():
    assert gate((False, 0.0), (True, 10.1), (False, 10.35)).was_open(10.0, 10.4)


def test_after_a_reset_it_stands_as_it_stood():
    made = gate((False, 0.0), (True, 5.0))
    made.reset()
    assert made.was_open(10.0, 11.0)


@pytest.mark.parametrize("back", [5.0, 600.0])
def test_after_the_clock_was_set_back_a_press_counts_as_it_is_reported(back):
    made = gate((True, 0.0), (False, 1000.0), (True, 1001.0))
    made.update(TalkChange(False, 1005.0 - back))
    assert not made.was_open(1006.0 - back, 1007.0 - back)
    made.update(TalkChange(True, 1008.0 - back))
    assert made.was_open(1009.0 - back, 1010.0 - back)


@pytest.mark.parametrize("is_open", [True, False])
def test_after_the_clock_was_set_back_it_stands_as_it_stood(is_open):
    assert gate((not is_open, 0.0), (is_open, 1000.0)).was_open(500.0, 501.0) is is_open
