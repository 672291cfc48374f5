# SPDX-License-Identifier: BSD-3-Clause
"""The simulator says whether the tissue it shows is triangulated."""

import numpy as np
import pytest

from rst_control.config import load_simulation_config
from rst_control.simulation.exposure import exposure, exposure_words
from rst_control.simulation.tissue import SimulatedTissue

SCENE = load_simulation_config().scene
STEP = 1e-3


def pulled(way, missed=(0.0, 0.0, 0.0), steps=600):
    """The shipped sheet, grasped a little off the point meant, and pulled by a way [m]."""
    tissue = SimulatedTissue(SCENE.tissue, STEP)
    tip = np.array(SCENE.grasp_point) + missed
    assert tissue.grasp(tip)
    for share in np.linspace(0.0, 1.0, steps):
        force = tissue.advance(tip + share * np.array(way))
    for _ in range(200):
        force = tissue.advance(tip + np.array(way))
    return tissue, force


def test_tissue_that_is_not_held_has_no_verdict():
    assert exposure(SimulatedTissue(SCENE.tissue, STEP), SCENE, np.zeros(3)) is None
    assert exposure_words(None, SCENE) == "no tissue held"


def test_the_sheet_pulled_upwards_is_triangulated():
    tissue, force = pulled((0.0, 0.0, 0.006))
    held = exposure(tissue, SCENE, force)
    assert exposure_words(held, SCENE) == "triangulated"
    assert held.tension == pytest.approx(np.linalg.norm(force))
    assert held.grasp_error < 1e-9


@pytest.mark.parametrize(
    ("way", "missed", "words"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), "N, at least 0.3"),
        ((0.0, 0.0, 0.006), (0.0, 0.0015, 0.0), "grasp error 1.5 mm, at most 1"),
        ((0.0, 0.0, 0.025), (0.0, 0.0, 0.0), "strain"),
    ],
)
def test_what_keeps_it_from_being_triangulated_is_named(way, missed, words):
    tissue, force = pulled(way, missed)
    words_now = exposure_words(exposure(tissue, SCENE, force), SCENE)
    assert words_now.startswith("not triangulated: ")
    assert words in words_now
