# SPDX-License-Identifier: BSD-3-Clause
"""Compiled arithmetic of the simulated robot, against numpy."""

from __future__ import annotations

import numpy as np
import pytest

from rst_control.robot import joint_kernels

RNG = np.random.default_rng(8)
LOWER, UPPER = -np.linspace(1.0, 2.0, 10), np.linspace(0.5, 1.5, 10)


def test_the_cubic_meets_both_set_points_and_its_velocity_is_its_slope():
    p, v, p_end, v_end = RNG.normal(size=(4, 10))

    def at(time: float) -> np.ndarray:
        return joint_kernels.hermite(p, v, 2.0, p_end, v_end, 2.3, time)

    assert np.allclose(at(2.0), [p, v], atol=1e-12)
    assert np.allclose(at(2.3), [p_end, v_end], atol=1e-12)
    for time in (2.05, 2.17, 2.26):
        slope = (at(time + 1e-6)[0] - at(time - 1e-6)[0]) / 2e-6
        assert np.allclose(slope, at(time)[1], atol=1e-7)


def test_a_position_is_clamped_joint_by_joint_and_the_first_one_outside_is_named():
    position = np.zeros(10)
    assert joint_kernels.outside(position, LOWER, UPPER) == -1
    position[[3, 7]] = 9.0, -9.0
    assert joint_kernels.outside(position, LOWER, UPPER) == 3
    assert np.array_equal(
        joint_kernels.clamped(position, LOWER, UPPER), np.clip(position, LOWER, UPPER)
    )
    assert position[3] == 9.0


def test_the_furthest_joint_is_found():
    a, b = RNG.normal(size=(2, 10))
    joint, away = joint_kernels.furthest(a, b)
    assert joint == np.abs(a - b).argmax()
    assert away == np.abs(a - b).max()


def test_a_joint_that_is_not_a_number_is_infinitely_far():
    a, b = RNG.normal(size=(2, 10))
    a[2] = np.nan
    assert joint_kernels.furthest(a, b) == (2, np.inf)


@pytest.mark.parametrize("by_step", [True, False])
def test_the_speed_is_the_larger_of_what_is_said_and_what_it_takes(by_step):
    last, allowed = np.zeros(10), np.full(10, 1.3)
    position, velocity = last.copy(), np.full(10, 0.1)
    (position if by_step else velocity)[4] = 0.004 if by_step else 2.0
    joint, speed = joint_kernels.fastest(position, velocity, last, 0.002, allowed)
    assert joint == 4
    assert speed == pytest.approx(2.0)
