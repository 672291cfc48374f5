# SPDX-License-Identifier: BSD-3-Clause
from itertools import pairwise

import numpy as np
import pytest

from rst_control.errors import Collision, JointLimitExceeded
from rst_control.kinematics import forward
from rst_control.planning import rrt_connect
from rst_control.planning.collision_kernels import min_room
from rst_control.planning.free_space import Approach, NoWay

DENSE = 400


@pytest.fixture(scope="module")
def approach(planner):
    patient = planner.patient
    return Approach(planner.model, planner.limits, patient.outside, patient.outward)


def free(planner, count, seed):
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        q = rng.uniform(planner.limits.lower, planner.limits.upper)
        if room(planner, q) >= 0.0:
            found.append(q)
    return found


def room(planner, q):
    return min_room(planner.model.chain, np.array(q), planner.patient.outside.shapes)[0]


def least_between(planner, a, b):
    return min(room(planner, a + share * (b - a)) for share in np.linspace(0.0, 1.0, DENSE))


def test_an_edge_found_free_is_free_everywhere_on_it(planner):
    places, shapes, seen = free(planner, 60, 1), planner.patient.outside.shapes, []
    for a, b in pairwise(places):
        share = rrt_connect.free_share(planner.model.chain, shapes, a, b)
        least = least_between(planner, a, b)
        seen.append(share == 1.0)
        if share == 1.0:
            assert least > -0.5 * rrt_connect.RESOLUTION
        else:
            assert room(planner, a + share * (b - a)) >= 0.0
    assert any(seen) and not all(seen)


def test_no_body_moves_further_than_the_bound_says(planner):
    shapes = planner.patient.outside.shapes
    for a, b in pairwise(free(planner, 40, 2)):
        near = a + 0.05 * (b - a)
        change = abs(room(planner, near) - room(planner, a))
        assert change <= rrt_connect.carried(a, near, shapes.reach)


def test_every_way_is_free_begins_at_the_start_and_ends_at_the_goal(planner, approach, gate):
    counts = []
    for q in free(planner, 25, 3):
        ways = approach.way(q, gate)
        counts.append(len(ways))
        np.testing.assert_allclose(ways[0].start, q)
        np.testing.assert_allclose(ways[-1].end, gate)
        for way, after in pairwise(ways):
            np.testing.assert_array_equal(way.end, after.start)
        for way in ways:
            assert least_between(planner, way.start, way.end) > -0.5 * rrt_connect.RESOLUTION
    assert min(counts) == 1 and max(counts) > 3  # straight, and round something


def test_the_same_question_gets_the_same_answer(planner, approach, gate):
    for q in free(planner, 12, 3):
        first, second = approach.way(q, gate), approach.way(q, gate)
        for one, other in zip(first, second, strict=True):
            np.testing.assert_array_equal(one.knots, other.knots)


def test_a_start_below_the_patients_surface_is_refused_with_what_is_too_near(approach, home, gate):
    with pytest.raises(Collision, match=r"from patient's surface, allowed 5\.0 mm"):
        approach.way(home, gate)


def test_a_start_beyond_a_joint_limit_is_refused(approach, gate, planner):
    beyond = gate.copy()
    beyond[1] = planner.limits.upper[1] + 0.01
    with pytest.raises(JointLimitExceeded, match="joint_2"):
        approach.way(beyond, gate)


def test_where_no_way_is_found_the_refusal_names_what_blocks(planner, approach, gate, monkeypatch):
    monkeypatch.setattr(rrt_connect, "connect", lambda *_: (-1, -1))
    refused = []
    for q in free(planner, 25, 3):
        try:
            approach.way(q, gate)
        except NoWay as error:
            refused.append(error)
            at = np.linspace(0.0, 1.0, 4000)[:, None]
            rooms = [room(planner, place) for place in q + at * (gate - q)]
            assert min(rooms) < 0.0
            assert error.blocked.first in str(error) and "tries found none" in str(error)
    assert refused


def test_a_leg_is_as_long_as_the_part_that_travels_furthest(approach, planner, home):
    turned = home + 0.5 * np.eye(9)[0]  # about the base's axis
    frames = np.empty((12, 3, 4))
    forward.forward(planner.model.chain, home, frames)
    radius = np.hypot(frames[:, 0, 3], frames[:, 1, 3]).max()
    assert approach.leg(home, turned).length == pytest.approx(0.5 * radius, rel=1e-3)
