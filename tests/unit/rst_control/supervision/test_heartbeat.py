# SPDX-License-Identifier: BSD-3-Clause
"""The voice node's heartbeats count by their age."""

import pytest

from rst_control.supervision.heartbeat import Heartbeat
from rst_control.types import Reason

ALLOWED = 0.14  # [s]
DAY = 1.8e9  # [s] some clock of the day


@pytest.fixture
def heartbeat():
    return Heartbeat(ALLOWED)


def test_a_heartbeat_that_comes_at_once_keeps_it_alive_for_as_long_as_allowed(heartbeat):
    assert heartbeat.beat(DAY, DAY, 10.0) == 10.0
    assert heartbeat.objection(10.13) is None
    assert heartbeat.objection(10.15).words == "voice node silent for 0.15 s, allowed 0.14 s"


def test_heartbeats_that_come_in_time_but_late_do_not(heartbeat):
    for n in range(40):
        now = 10.0 + 0.05 * n
        assert heartbeat.beat(DAY + now - 0.5, DAY + now, now) == pytest.approx(now - 0.5)
        words = heartbeat.objection(now).words
        assert ("silent for 0.50 s" if n < 3 else "stamped 0.50 s late, allowed 0.14 s") in words


def test_a_burst_of_old_heartbeats_after_a_cut_does_not(heartbeat):
    for n in range(20):
        heartbeat.beat(DAY + 0.05 * n, DAY + 4.0, 14.0)
    assert "silent" in heartbeat.objection(14.0).words


def test_an_older_heartbeat_that_comes_later_takes_nothing_back(heartbeat):
    heartbeat.beat(DAY, DAY, 10.0)
    assert heartbeat.beat(DAY - 1.0, DAY + 0.01, 10.01) == 10.0
    assert heartbeat.objection(10.1) is None


def test_a_clock_that_is_ahead_by_more_than_allowed_counts_as_silence(heartbeat):
    heartbeat.beat(DAY + 0.2, DAY, 10.0)
    assert "without heartbeat" in heartbeat.objection(10.0).words


def heard(by, beats=20):
    """Heartbeats in time, from a clock that is ahead [s]; the last one at 10 s."""
    heartbeat = Heartbeat(ALLOWED)
    for n in range(beats):
        now = 10.0 - 0.05 * (beats - 1 - n)
        heartbeat.beat(DAY + now + by, DAY + now, now)
    return heartbeat


@pytest.mark.parametrize(
    ("by", "stamped"), [(3600.0, "3600.00 s ahead"), (-3600.0, "3600.00 s late")]
)
def test_a_clock_that_is_not_set_is_named_and_forbids_as_silence_does(by, stamped):
    cause = heard(by).objection(10.02)
    assert cause.reason is Reason.VOICE_SILENT
    assert (
        f"heartbeats come, but are stamped {stamped}, allowed 0.14 s: are the clocks" in cause.words
    )


@pytest.mark.parametrize("by", [3600.0, -3600.0])
def test_once_no_heartbeats_come_the_clocks_are_not_named(by):
    assert "clocks" not in heard(by).objection(10.0 + ALLOWED + 0.01).words


def test_a_clock_that_is_set_again_is_forgotten():
    heartbeat = heard(3600.0)
    heartbeat.beat(DAY + 10.05, DAY + 10.05, 10.05)
    assert heartbeat.objection(10.06) is None
    assert "silent for 0.15 s" in heartbeat.objection(10.2).words


def test_a_clock_that_is_ahead_by_less_keeps_nothing_alive_for_longer(heartbeat):
    assert heartbeat.beat(DAY + 0.1, DAY, 10.0) == 10.0


def test_without_a_stamp_it_counts_from_its_arrival(heartbeat):
    assert heartbeat.beat(0.0, DAY, 10.0) == 10.0
    assert heartbeat.objection(10.1) is None


def test_who_never_sent_one_may_move_nothing():
    assert "without heartbeat" in Heartbeat(ALLOWED).objection(0.0).words
