# SPDX-License-Identifier: BSD-3-Clause
"""The wall clock against the steady one, read by a thread that may be put aside."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rst_control.ros.common.wall_clock import CLOCK_JUMP, READINGS, followed, wall_offset

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


def test_only_a_change_beyond_the_limit_is_followed() -> None:
    for change, is_followed in ((0.5 * CLOCK_JUMP, False), (2.0 * CLOCK_JUMP, True)):
        wall, steady = clocks([])
        found = followed(AHEAD - change, wall, steady)
        assert found == pytest.approx(AHEAD if is_followed else AHEAD - change, abs=1e-5)
