# SPDX-License-Identifier: BSD-3-Clause
"""Whole grasps in the lab plant: what makes up for play and friction lets them count."""

import numpy as np
import pytest

from bench.site.plant import ALL_PLANTS, AS_IT_IS, make_rig
from bench.site.plant_session import Seen, Session

FIXED = "lab, fixed trocar"


@pytest.fixture(scope="module")
def seen():
    """A cycle of commands with all that is made up for, and without."""

    def carried_out(plant):
        with make_rig("set-points", plant) as rig:
            return Session(rig, has_tool=False).run(1.0)

    return {plant: carried_out(plant) for plant in ALL_PLANTS if plant.startswith(FIXED)}


def test_a_grasp_counts_once_play_is_made_up_for(seen: dict[str, Seen]):
    assert seen[FIXED].triangulated == [True]
    assert seen[f"{FIXED}, {AS_IT_IS}"].triangulated == [False]


def test_the_shaft_stays_nearer_to_its_trocar(seen: dict[str, Seen]):
    off, bare = (np.quantile(each.rcm, 0.99) for each in seen.values())
    assert off < 0.75 * bare < 0.5e-3


def test_nothing_is_stopped_or_refused_needlessly(seen: dict[str, Seen]):
    for each in seen.values():
        assert each.needless == [] and np.abs(each.tension).max() < 0.1
