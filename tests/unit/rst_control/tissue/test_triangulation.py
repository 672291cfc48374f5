# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rst_control.config import TriangulationConfig
from rst_control.tissue.triangulation import (
    best_anchors,
    out_of_plane,
    pull_direction,
    triangle_angles,
    triangulation,
)

LIMITS = TriangulationConfig(
    grasp_error=0.001,
    min_angle=np.radians(30.0),
    out_of_plane=0.001,
    tension=(0.3, 1.0),
    strain=0.6,
)
coordinates = st.floats(-0.1, 0.1)
points = st.tuples(coordinates, coordinates, coordinates).map(np.array)


def sheet(bulge=0.0):
    """A square of 60 mm in the plane y = 0, fixed below, bulging towards y."""
    x, z = np.meshgrid(np.linspace(-0.03, 0.03, 13), np.linspace(0.0, 0.06, 13), indexing="ij")
    y = bulge * np.sin(np.pi * z / 0.06)
    nodes = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    return nodes, nodes[:, 2] == 0.0


def held(bulge=0.0, jaws=(0.0, 0.0, 0.06), missed=(0.0, 0.0, 0.0), tension=0.6, strain=0.2):
    return triangulation(*sheet(bulge), np.array(jaws), np.array(missed), tension, strain)


def test_a_flat_taut_sheet_held_in_the_middle_is_triangulated():
    found = held()
    assert found.failures(LIMITS) == ()
    assert found.out_of_plane == pytest.approx(0.0, abs=1e-12)
    assert np.degrees(found.min_angle) > 50.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"bulge": 0.004}, "out of plane"),
        ({"missed": (0.0, 0.0011, 0.0)}, "grasp error 1.1 mm, at most 1"),
        ({"jaws": (0.0, 0.0, 0.002)}, "angle"),
        ({"tension": 0.2}, "tension 0.2 N, at least 0.3"),
        ({"tension": 1.2}, "tension 1.2 N, at most 1"),
        ({"strain": 0.7}, "strain 0.7"),
        ({"strain": np.nan}, "strain nan, at most 0.6"),
    ],
)
def test_each_fault_is_found_alone_and_named(change, words):
    if "jaws" in change:
        nodes, _ = sheet()
        rim = (np.abs(nodes[:, 0]) == 0.03) & (nodes[:, 2] == 0.0)  # only the two far corners
        found = triangulation(nodes, rim, np.array(change["jaws"]), np.zeros(3), 0.6, 0.2)
    else:
        found = held(**change)
    (failure,) = found.failures(LIMITS)
    assert words in failure


@given(points, points, points)
def test_angles_of_a_triangle_add_up_to_half_a_turn(a, b, c):
    if np.linalg.norm(np.cross(b - a, c - a)) > 1e-6:
        assert triangle_angles(a, b, c).sum() == pytest.approx(np.pi)


def test_anchors_are_the_pair_with_the_largest_least_angle():
    rng = np.random.default_rng(0)
    rim, jaws = rng.uniform(-0.1, 0.1, (12, 3)), rng.uniform(-0.1, 0.1, 3)
    best = max(
        triangle_angles(rim[i], rim[j], jaws).min() for i in range(12) for j in range(i + 1, 12)
    )
    found = best_anchors(rim, jaws)
    assert triangle_angles(found[0], found[1], jaws).min() == pytest.approx(best)


def test_a_rim_of_one_point_holds_nothing():
    with pytest.raises(ValueError, match="2 and more"):
        best_anchors(np.zeros((1, 3)), np.ones(3))


def test_nodes_outside_the_triangle_do_not_count():
    nodes, _ = sheet()
    corner = np.abs(nodes[:, 0]) > 0.02
    nodes[corner & (nodes[:, 2] > 0.03), 1] = 0.01
    a, b, c = np.array([-0.03, 0.0, 0.0]), np.array([0.03, 0.0, 0.0]), np.array([0.0, 0.0, 0.06])
    assert out_of_plane(nodes, a, b, c) == pytest.approx(0.0, abs=1e-12)


def test_the_pull_leads_from_between_the_anchors_to_the_grasp():
    nodes, rim = sheet()
    assert_allclose(pull_direction(nodes[rim], np.array([0.0, 0.0, 0.06])), [0, 0, 1], atol=1e-9)


def test_all_faults_are_reported_together():
    found = replace(held(bulge=0.004), tension=0.1, strain=0.9)
    assert len(found.failures(LIMITS)) == 3
