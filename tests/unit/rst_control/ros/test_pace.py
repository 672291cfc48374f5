# SPDX-License-Identifier: BSD-3-Clause
"""Simulated time against the clock."""

from __future__ import annotations

import pytest

from rst_control.ros.simulator.pace import SimulationPace


class World:
    """Its pace is kept at 500 Hz; the clock goes on only while that sleeps."""

    def __init__(self, factor: float = 1.0) -> None:
        self.now, self.naps = 10.0, 0
        self.pace = SimulationPace(0.002, factor, lambda: self.now, self.sleep)

    def sleep(self, duration: float) -> None:
        self.now += duration
        self.naps += 1


@pytest.mark.parametrize("factor", [0.5, 1.0, 4.0])
def test_simulated_time_keeps_its_factor(factor):
    world = World(factor)
    for _ in range(1000):
        world.pace.wait()
    assert world.now == pytest.approx(10.0 + 2.0 / factor)
    assert world.pace.late == 0


def test_lateness_is_made_up_for_without_a_pause():
    world = World()
    world.now += 0.05
    late = [world.pace.wait() for _ in range(30)]
    assert late[0] == pytest.approx(0.048)
    assert late[-1] == pytest.approx(0.0)
    assert world.pace.late == pytest.approx(24, abs=1)
    assert world.now == pytest.approx(10.0 + 30 * 0.002)
    assert world.naps == 30, "each time, others of its priority get their turn"


def test_what_is_given_up_is_not_made_up_for():
    world = World()
    world.now += 5.0
    world.pace.give_up(world.pace.wait())
    world.pace.wait()
    assert world.now == pytest.approx(15.002)
    assert world.pace.given_up == pytest.approx(4.998)


def test_factor_zero_never_waits():
    world = World(0.0)
    for _ in range(100):
        assert world.pace.wait() == 0.0
    assert world.now == 10.0
