# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rst_control.tension.stiffness import StiffnessEstimate

STEP = 2e-5  # [m]
SPEED = 0.01  # [m/s]
NOISE = 0.005  # [N]


def estimate():
    return StiffnessEstimate(20.0, 4000.0, NOISE)


def pulled(found, stiffness, steps, s=0.0, force=0.0, noise=None):
    for n in range(1, steps + 1):
        seen = force + stiffness * n * STEP + (noise.normal(0.0, NOISE) if noise else 0.0)
        found.update(s + n * STEP, seen, SPEED)
    return s + steps * STEP, force + stiffness * steps * STEP


def test_tissue_of_which_nothing_is_known_counts_as_the_stiffest():
    assert estimate().cautious == pytest.approx(4000.0)


@pytest.mark.parametrize("stiffness", [20.0, 80.0, 600.0, 4000.0])
@pytest.mark.parametrize("seed", range(5))
def test_the_slope_is_found_under_noise_and_caution_lies_above_it(stiffness, seed):
    found = estimate()
    _, force = pulled(found, stiffness, 150, noise=np.random.default_rng(seed))
    assert found.value == pytest.approx(stiffness, rel=0.15, abs=10.0)
    assert found.cautious >= 0.97 * stiffness
    assert found.force == pytest.approx(force, abs=2.0 * NOISE + 0.01 * force)


@pytest.mark.parametrize("before", [80.0, 200.0, 400.0])
def test_tissue_that_stiffens_tenfold_counts_as_stiff_within_a_tenth_of_a_millimetre(before):
    found = estimate()
    s, force = pulled(found, before, 300)
    assert found.cautious < 2.0 * before
    pulled(found, 10.0 * before, 5, s, force)
    assert found.cautious > 8.0 * before


@given(st.floats(0.0, 3.0))
def test_a_standing_tip_teaches_no_softness(force):
    found = estimate()
    for _ in range(100):
        found.update(0.001, force, 0.0)
    assert found.cautious >= 4000.0
    assert found.force == pytest.approx(force, abs=1e-9)


def test_noise_at_rest_is_filtered():
    found, noise = estimate(), np.random.default_rng(1)
    forces = []
    for _ in range(2000):
        found.update(0.001, 1.0 + noise.normal(0.0, NOISE), 0.0)
        forces.append(found.force)
    assert np.std(forces[500:]) < 0.5 * NOISE
