# SPDX-License-Identifier: BSD-3-Clause
"""Distances, what the capsules cover and what is left out, judged by PyBullet and the drawing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.motion.bullet.bodies import BulletBodies
from rst_control.description.facts import load_facts
from rst_control.kinematics import forward
from rst_control.planning import collision_kernels as kernels
from rst_control.planning.collision import CollisionModel
from rst_control.trajectory.path import Path

COUNT = 1000
PLACES = 500
AGREEMENT = 1e-6  # [m]
FAR_APART = 0.015  # [m] that bodies keep which are left out because they cannot meet
JOINED = {  # links that a joint or bolts join, or that a link between holds at one place
    "shoulder_link": {"base_link", "half_arm_1_link"},
    "half_arm_2_link": {"half_arm_1_link", "forearm_link"},
    "spherical_wrist_1_link": {"forearm_link", "spherical_wrist_2_link"},
    "bracelet_link": {"spherical_wrist_2_link", "tool0"},
    "tool0": {"spherical_wrist_2_link", "interface_link", "pitch_link", "finger_left_link"},
    "pitch_link": {"interface_link", "finger_left_link"},
    "finger_left_link": {"interface_link"},
}
BY_LIMIT = {  # kept apart by the limit of the joint between, by less than FAR_APART
    frozenset(("base_link", "half_arm_1_link")),
    frozenset(("forearm_link", "spherical_wrist_2_link")),
}


@pytest.fixture(scope="module")
def config(motion_config):
    return motion_config.collision


@pytest.fixture(scope="module")
def bullet(config):
    with BulletBodies(config) as bodies:
        yield bodies


@pytest.fixture(scope="module")
def model(config, robot):
    return CollisionModel(config, robot)


def joints(planner, count, seed):
    """Random joints, a third of them at their limits."""
    rng, limits = np.random.default_rng(seed), planner.limits
    lower, upper = np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi)
    q = rng.uniform(lower, upper, (count, 9))
    edge = rng.uniform(size=q.shape)
    return np.where(edge < 1 / 6, lower, np.where(edge > 5 / 6, upper, q))


def test_distance_and_names_equal_pybullets_over_a_thousand_configurations(planner, model, bullet):
    for q in joints(planner, COUNT, seed=2):
        distance, names = bullet.nearest(q)
        found = model.clearance(q)
        assert abs(found.distance - distance) < AGREEMENT
        if {found.first, found.second} != names:  # two are equally near
            others = [d for d, other in bullet.distances(q) if other == {found.first, found.second}]
            assert abs(min(others) - distance) < AGREEMENT


points = st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3)
segments = st.tuples(points, points).map(lambda ends: np.array([*ends[0], *ends[1]]))


@given(segments, segments)
def test_the_distance_of_two_lines_is_the_least_between_their_points(a, b):
    share = np.linspace(0.0, 1.0, 41)[:, None]
    on_a, on_b = (s[:3] + share * (s[3:] - s[:3]) for s in (a, b))
    least = np.linalg.norm(on_a[:, None] - on_b[None], axis=-1).min()
    distance = kernels.segment_distance(a, b)
    lengths = np.linalg.norm(a[3:] - a[:3]) + np.linalg.norm(b[3:] - b[:3])
    alike = 1e-9 + 1e-6 * lengths  # lines within a millionth of parallel count as parallel
    assert least - lengths / 80.0 - alike <= distance <= least + alike
    assert kernels.segment_distance(b, a) == pytest.approx(distance, abs=alike)


@given(segments, points)
def test_a_line_without_length_is_a_point(a, point):
    b = np.array([*point, *point])
    share = np.linspace(0.0, 1.0, 2001)[:, None]
    least = np.linalg.norm(a[:3] + share * (a[3:] - a[:3]) - b[:3], axis=1).min()
    assert kernels.segment_distance(a, b) == pytest.approx(least, abs=5e-4)
    assert kernels.segment_distance(b, b) == 0.0


def surface(visual):
    """Points on the surface of a drawn shape, frame of its link (n, 3)."""
    if visual.shape == "box":
        sides = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)
        return np.array(visual.at) + sides * visual.size  # its corners: capsules are convex
    rng = np.random.default_rng(3)
    ball = rng.normal(size=(60, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    if visual.shape == "sphere":
        return np.array(visual.at) + visual.radius * ball
    start, end = np.array(visual.from_), np.array(visual.to)
    axis = (end - start) / np.linalg.norm(end - start)
    rim = ball - np.outer(ball @ axis, axis)
    rim *= visual.radius / np.linalg.norm(rim, axis=1)[:, None]
    return np.vstack([start + rim, end + rim])


def test_everything_drawn_of_the_robot_is_inside_the_capsules_of_its_link(config):
    drawn = [v for v in load_facts().visuals if not v.link.startswith("finger")]
    assert len(drawn) > 30
    rigid = {"tool0", "interface_link"}  # bolted together, so either may cover the other's rim
    for visual in drawn:
        link, outside = visual.link, np.inf
        links = rigid if link in rigid else {link}
        for body in config.bodies:
            if body.link not in links:
                continue
            shift = _between(body.link, link)
            ends = np.array([*body.start, *body.end])
            distance = [
                kernels.segment_distance(ends, np.array([*p, *p])) - body.radius
                for p in surface(visual) + shift
            ]
            outside = np.minimum(outside, distance)
        assert outside.max() <= 0.0, f"{visual} sticks out {outside.max() * 1e3:.2f} mm"


def _between(to, from_):
    """Where the origin of a link is in the frame of another that it is bolted to."""
    at = np.array(next(j.xyz for j in load_facts().joints if j.child == "interface_link"))
    return (from_ == "interface_link") * at - (to == "interface_link") * at


@pytest.mark.parametrize("opening", [0.0, 0.6, 1.5])
def test_jaws_however_far_open_are_inside_their_capsule(config, opening):
    (jaws,) = [body for body in config.bodies if body.link == "finger_left_link"]
    ends = np.array([*jaws.start, *jaws.end])
    for visual in load_facts().visuals:
        if not visual.link.startswith("finger"):
            continue
        left = visual.link == "finger_left_link"
        angle = 0.5 * opening  # the right one hangs the other way about, and turns against it
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        flip = np.eye(3) if left else np.diag([-1.0, 1.0, -1.0])
        for point in surface(visual) @ turn.T @ flip.T:
            assert kernels.segment_distance(ends, np.array([*point, *point])) < jaws.radius


def test_what_is_left_out_is_joined_or_cannot_meet_within_the_joint_limits(
    planner, config, robot, model
):
    left_out = {frozenset((e.link, other)) for e in config.left_out for other in e.others}
    joined = {frozenset((a, b)) for a, others in JOINED.items() for b in others}
    assert joined <= left_out
    apart = left_out - joined
    bodies, pairs = config.bodies, []
    for a in range(len(bodies)):
        for b in range(a):
            if frozenset((bodies[a].link, bodies[b].link)) in apart:
                pairs.append((a, b))
    frames, ends = np.empty((12, 3, 4)), np.empty((len(bodies), 6))
    for q in joints(planner, 3000, seed=6):
        forward.forward(robot.chain, q, frames)
        kernels.place(frames, model.shapes, ends)
        for a, b in pairs:
            links = frozenset((bodies[a].link, bodies[b].link))
            distance = kernels.segment_distance(ends[a], ends[b])
            least = 0.0 if links in BY_LIMIT else FAR_APART
            assert distance - bodies[a].radius - bodies[b].radius > least, (links, q)


def test_every_link_but_neighbours_is_checked_against_the_shaft_where_it_can_meet_it(config, model):
    checked = {
        frozenset((config.bodies[a].link, config.bodies[b].link)) for a, b in model.shapes.pairs
    }
    for link in ("base_link", "shoulder_link", "half_arm_1_link", "half_arm_2_link"):
        for tool in ("interface_link", "tool0"):
            assert frozenset((link, tool)) in checked


def test_no_path_passes_the_check_by_hopping_over(planner, robot, model):
    """Only both ends of long joint motions are sampled; judged at 500 places of each."""
    rng, limits, hidden = np.random.default_rng(17), planner.limits, 0
    lower, upper = np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi)

    def room_at(q):
        return kernels.min_room(robot.chain, q, model.shapes)[0]

    for _ in range(60):
        middle, room = np.zeros(9), np.inf
        while not -0.01 < room < 0.005:
            middle = rng.uniform(lower, upper)
            room = room_at(middle)
        steps = 1e-6 * np.eye(9)
        slope = np.array([room_at(middle + step) - room_at(middle - step) for step in steps])
        turn = rng.uniform(0.02, 0.5) * rng.normal(size=9)
        turn -= slope * (slope @ turn) / (slope @ slope)  # past each other, as convex bodies pass
        start, end = np.clip(middle - turn, lower, upper), np.clip(middle + turn, lower, upper)
        path = Path(np.array([start, end]), np.tile(end - start, (2, 1)), 1.0)
        samples = path.sample(robot.chain, planner.trocar, per_knot=1)
        places = np.linspace(0.0, 1.0, PLACES + 1)
        rooms = [room_at(path.evaluate(s).q) for s in places]
        bound = kernels.motion_bound(samples.q, 0, samples.s[1], model.shapes.reach)
        room, _ = kernels.sweep(robot.chain, samples.q, samples.s[1], model.shapes)
        if room < 0.0:
            assert min(rooms) < bound / PLACES  # it is true
        else:
            assert min(rooms) >= -0.5 * kernels.RESOLUTION
        hidden += min(rooms[0], rooms[-1]) >= 0.0 > room
    assert hidden >= 5  # both ends are free, and what lies between is not


@given(st.integers(0, 10_000))
def test_no_body_moves_further_than_the_bound_of_its_path(planner, robot, model, seed):
    rng, limits = np.random.default_rng(seed), planner.limits
    start, end = rng.uniform(limits.lower, limits.upper, (2, 9))
    path = Path(np.array([start, end]), rng.normal(size=(2, 9)), 1.0)
    samples = path.sample(robot.chain, planner.trocar)
    frames, ends = np.empty((12, 3, 4)), np.empty((2, len(model.shapes.capsules), 6))
    for k in range(len(samples.s) - 1):
        for n in range(2):
            forward.forward(robot.chain, samples.q[k + n, 0], frames)
            kernels.place(frames, model.shapes, ends[n])
        moved = np.linalg.norm((ends[1] - ends[0]).reshape(-1, 3), axis=1).max()
        bound = kernels.motion_bound(samples.q, k, samples.s[1], model.shapes.reach)
        assert moved <= bound + 1e-12
