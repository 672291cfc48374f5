# SPDX-License-Identifier: BSD-3-Clause
"""The wall clock against the steady one, read by a thread that may be put aside."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

from rst_control.ros.common import wall_clock
from rst_control.ros.common.wall_clock import (
    CLOCK_JUMP,
    READINGS,
    ArrivalOffset,
    RosClock,
    followed,
    wall_offset,
)
from rst_control.ros.simulator.messages import Stamper

AHEAD = 1.7e9  # [s] that the wall clock is ahead


def clocks(delays: list[float]) -> tuple[Callable[[], float], Callable[[], float]]:
    """Wall and steady clock; each reading takes 1 us, given ones come late [s]."""
    state = {"now": 5.0, "read": 0}

    def steady() -> float:
        late = delays[state["read"]] if state["read"] < len(delays) else 0.0
        state["read"] += 1
        state["now"] += 1e-6 + late
        return state["now"]

    def wall() -> float:
        state["now"] += 1e-6
        return AHEAD + state["now"]

    return wall, steady


def test_being_put_aside_between_two_readings_is_no_jump() -> None:
    wall, steady = clocks([0.0, 0.05])  # 50 ms between the wall clock and the reading behind it
    assert wall_offset(wall, steady) == pytest.approx(AHEAD, abs=1e-5)


def test_a_jump_of_the_wall_clock_is_seen() -> None:
    wall, steady = clocks([])
    assert wall_offset(lambda: wall() + 2.0, steady) == pytest.approx(AHEAD + 2.0, abs=1e-5)


def test_put_aside_every_time_it_is_wrong_by_no_more_than_half_of_that() -> None:
    wall, steady = clocks([0.0, 0.004] * READINGS)
    assert abs(wall_offset(wall, steady) - AHEAD) <= 0.0021


@pytest.mark.parametrize("jump", [0.06, -0.06, 30.0])
def test_two_nodes_agree_about_stamps_as_soon_as_the_clock_is_set(monkeypatch, jump) -> None:
    """Each reads the clock for each stamp; their messages are never early or late meanwhile."""
    sender, receiver, now = RosClock(), Stamper(is_real_time=True), time.monotonic()
    before = sender.stamp(now).to_sec()
    assert before - receiver.ahead() == pytest.approx(now, abs=CLOCK_JUMP)
    monkeypatch.setattr(wall_clock, "wall_offset", lambda *_: wall_offset() + jump)
    stamp = sender.stamp(now).to_sec()
    assert stamp == pytest.approx(before + jump, abs=2 * CLOCK_JUMP)
    assert stamp - receiver.ahead() == pytest.approx(now, abs=CLOCK_JUMP)
    seconds, rest = receiver.split(now)
    assert sender.steady(seconds + 1e-9 * rest) == pytest.approx(now, abs=CLOCK_JUMP)


def test_only_a_change_beyond_the_limit_is_followed() -> None:
    for change, is_followed in ((0.5 * CLOCK_JUMP, False), (2.0 * CLOCK_JUMP, True)):
        wall, steady = clocks([])
        found = followed(AHEAD - change, wall, steady)
        assert found == pytest.approx(AHEAD if is_followed else AHEAD - change, abs=1e-5)


def test_only_the_first_message_after_the_clock_was_set_back_cannot_be_read() -> None:
    readings = iter((5.0, 5.0, 8.0, 7.9, 7.9))
    offset = ArrivalOffset(lambda: next(readings))
    assert [offset() for _ in range(4)] == [5.0, 8.0, None, 7.9]
