# SPDX-License-Identifier: BSD-3-Clause
"""Feedback in our order, the arm's ramps, the stop guard, and the settings."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rst_control.config import CONFIG_FOLDER, LimitsConfig
from rst_control.kinova.brake_plan import LastCourse
from rst_control.kinova.config import BridgeConfig, load_kinova_config, require_drivable
from rst_control.kinova.feedback import BadFeedback, FeedbackReader, unwrapped
from rst_control.kinova.guard import StopGuard
from rst_control.kinova.velocity_follower import Follower
from rst_control.kinova.velocity_ramp import Ramp, feasible_share, velocity_for
from typed_config import ConfigError, load_config, load_yaml

NAMES = ("a", "b", "c")
TIME = 0.025


def values(*position):
    return {"position": position, "velocity": (0.0,) * len(position), "effort": ()}


class TestFeedback:
    def test_other_orders_and_strangers_are_put_right(self):
        read = FeedbackReader(NAMES, (1.0, 1.0, -1.0), None)
        reading = read.read(("c", "x", "a", "b"), values(3.0, 9.0, 1.0, 2.0), 5.0)
        np.testing.assert_allclose(reading.position, [1.0, 2.0, -3.0])
        assert reading.stamp == 5.0

    @pytest.mark.parametrize(
        ("names", "position", "words"),
        [
            (("a", "b"), (1.0, 2.0), "without c"),
            (NAMES, (1.0, 2.0), "2 values of position, allowed: 3"),
            (NAMES, (1.0, float("nan"), 2.0), r"position is \[1.0, nan, 2.0\], allowed: finite"),
        ],
    )
    def test_what_cannot_be_used_is_refused(self, names, position, words):
        read = FeedbackReader(NAMES, (1.0, 1.0, 1.0), (0.0,) * 3)
        with pytest.raises(BadFeedback, match=words):
            read.read(names, values(*position), 0.0)

    def test_angles_go_on_over_half_a_turn(self):
        read = FeedbackReader(("a",), (1.0,), (1.0,))
        course = np.linspace(2.0, 9.0, 200)
        reading = [
            read.read(("a",), values(float(np.mod(q + np.pi, 2 * np.pi) - np.pi)), 0.0).position
            for q in course
        ]
        np.testing.assert_allclose(np.ravel(reading), course, atol=1e-12)

    def test_the_first_state_is_in_the_turn_of_home(self):
        read = FeedbackReader(NAMES, (1.0, 1.0, 1.0), (3.1, -3.1, float("nan")))
        read_on = read.read(NAMES, values(-3.1, 3.1, 3.1), 0.0)
        turn = 2 * np.pi
        np.testing.assert_allclose(read_on.position, [turn - 3.1, 3.1 - turn, 3.1])
        read_on = read.read(NAMES, values(-3.0, 3.0, -3.1), 0.025)
        np.testing.assert_allclose(read_on.position, [turn - 3.0, 3.0 - turn, -3.1])

    def test_a_limited_joint_that_was_guided_far_in_an_outage_is_where_the_driver_says(self):
        config = load_kinova_config()
        names = config.bridge.arm.joints
        read = FeedbackReader(names, (1.0,) * 7, config.first_turns)
        for joint_4 in (2.3, -1.2, 2.3):
            reading = read.read(names, values(*(0.0,) * 3, joint_4, *(0.0,) * 3), 0.0)
            assert reading.position[3] == joint_4

    def test_only_joints_that_turn_for_ever_take_the_turn_of_home(self):
        config = load_kinova_config()
        is_endless = np.isfinite(config.first_turns)
        assert is_endless.tolist() == [True, False] * 3 + [True]
        np.testing.assert_array_equal(
            np.array(config.first_turns)[is_endless], config.scene.home[0:7:2]
        )

    @given(st.floats(-20.0, 20.0), st.floats(-3.0, 3.0))
    def test_unwrapping_takes_the_nearest_turn(self, last, step):
        reading = np.mod(np.array([last + step]) + np.pi, 2 * np.pi) - np.pi
        np.testing.assert_allclose(unwrapped(reading, np.array([last])), [last + step], atol=1e-9)


vectors = st.lists(st.floats(-0.3, 0.3), min_size=4, max_size=4).map(np.array)


class TestRamp:
    @settings(max_examples=60)
    @given(vectors, vectors)
    def test_the_velocity_for_a_way_goes_that_way(self, velocity, more):
        acceleration = np.array([1.0, 1.0, 5.0, 10.0])
        half = 0.5 * acceleration * TIME * TIME
        way = velocity * TIME + np.clip(more, -1.0, 1.0) * half
        wanted = velocity_for(way, velocity, acceleration, TIME)
        end, reached = Ramp(1.0, np.zeros(4), velocity, wanted, acceleration).at(1.0 + TIME)
        np.testing.assert_allclose(end, way, atol=1e-9)
        np.testing.assert_allclose(reached, wanted, atol=1e-9)

    @settings(max_examples=60)
    @given(vectors, vectors)
    def test_a_share_of_any_way_can_be_gone_by_all_where_one_can_be(self, velocity, way):
        acceleration = np.full(4, 1.0)
        share = feasible_share(way, velocity, acceleration, TIME)
        assert share >= 0.0
        off = np.abs(share * way - velocity * TIME) - 0.5 * acceleration * TIME**2
        ones = np.abs(way - velocity * TIME) - 0.5 * acceleration * TIME**2
        if (ones <= 0.0).all():
            assert share == 1.0
        elif share not in (0.0, 1.0) and (np.abs(velocity) < 1e-12).all():
            assert off.max() <= 1e-9

    def test_it_stays_at_the_velocity_it_reached(self):
        ramp = Ramp(0.0, np.zeros(1), np.zeros(1), np.array([0.1]), np.ones(1))
        place, velocity = ramp.at(1.0)
        assert place[0] == pytest.approx(0.1 * 0.1 / 2 + 0.1 * 0.9)
        assert velocity[0] == 0.1


class TestFollower:
    @pytest.mark.parametrize("ahead", [0.001, 0.010])
    def test_an_arm_behind_its_course_catches_up_without_swinging_about_it(self, kinova, ahead):
        arm, speed = kinova.bridge.arm, np.array([0.10, -0.14, 0.05, 0.19, 0.04, -0.19, 0.03])
        line = speed / np.linalg.norm(speed)
        follower, place = Follower(arm, np.full(7, 0.41)), np.zeros(7)
        follower.start(place, 0.0)
        ramp = Ramp(0.0, place, place, place, np.array(arm.acceleration))
        off, left = [], []
        for count in range(1, 120):
            now, grown = count * arm.period, min((count + 1) * arm.period, 0.32)
            gone = 0.5 * grown**2 / 0.32 + max(0.0, (count + 1) * arm.period - 0.32)
            goal = gone * speed + ahead * line
            place, velocity = ramp.at(now)
            ramp = Ramp(now, place, velocity, follower.step(goal, now), ramp.acceleration)
            off.append(np.abs(place - (place @ line) * line).max())
            left.append((goal - arm.period * speed - place) @ line)
        assert max(off) < 1e-3
        assert min(left[20:]) > -2e-3
        assert max(np.abs(left[60:])) < 1e-4


class TestGuard:
    @pytest.fixture
    def guard(self, kinova):
        return StopGuard(kinova.bridge)

    def stops(self, guard, begin, end):
        return [t for t in np.arange(begin, end, 0.01) if guard.is_stop_due(float(t))]

    def test_it_never_stops_what_never_moved(self, guard):
        assert self.stops(guard, 0.0, 10.0) == []

    def test_a_bridge_that_beats_is_left_alone(self, guard):
        for t in np.arange(0.0, 5.0, 0.02):
            guard.heard(float(t))
            assert not guard.is_stop_due(float(t) + 0.01)

    def test_silence_stops_the_arm_soon_and_again_and_not_for_ever(self, guard, kinova):
        config = kinova.bridge.guard
        guard.heard(1.0)
        found = self.stops(guard, 1.0, 20.0)
        assert found[0] == pytest.approx(1.0 + config.silence, abs=0.02)
        assert len(found) > 20
        assert found[-1] <= 1.0 + config.silence + config.insist + 0.02

    @pytest.mark.parametrize("insist", [0.1, 2.0])
    def test_after_braking_it_stops_as_often_as_after_silence(self, kinova, insist):
        bridge, speeds = kinova.bridge, np.full(7, 0.4)
        guard = StopGuard(replace(bridge, guard=replace(bridge.guard, insist=insist)))
        still = np.zeros(7)
        guard.heard(1.0, LastCourse(1.0, still, speeds, speeds, 0.025 * speeds, speeds, still))
        now, braked, stops = 1.0, [], []
        while now < 10.0:
            now += 0.01
            if guard.speeds_due(now) is not None:
                braked.append(now)
            elif guard.is_stop_due(now):
                stops.append(now)
        assert braked[-1] - braked[0] > 0.6  # 0.4 rad/s at 0.6 rad/s^2
        assert stops[0] == pytest.approx(braked[-1], abs=0.02)
        assert stops[-1] == pytest.approx(braked[-1] + insist, abs=0.04)

    def test_it_hears_the_bridge_only_while_beats_come(self, guard, kinova):
        config = kinova.bridge.guard
        assert not guard.hears_bridge(0.0)
        guard.heard(1.0)
        assert guard.hears_bridge(1.0 + 0.9 * config.silence)
        end = 1.0 + config.silence + config.insist
        for t in np.arange(1.0 + 1.1 * config.silence, end + 1.0, 0.01):
            assert not guard.hears_bridge(float(t))
            guard.is_stop_due(float(t))
        guard.heard(11.0)
        assert guard.hears_bridge(11.01)

    def test_a_bridge_that_comes_back_is_guarded_again(self, guard):
        guard.heard(1.0)
        self.stops(guard, 1.0, 10.0)
        guard.heard(11.0)
        assert not guard.is_stop_due(11.05)
        assert self.stops(guard, 11.0, 11.5)


def test_a_brake_that_the_driver_cannot_keep_is_refused():
    data = load_yaml(CONFIG_FOLDER / "kinova_bridge.yaml")
    data["servo"]["brake_deceleration"][0] = 2.0
    with pytest.raises(ConfigError, match=r"brake_deceleration.*2.0.*of joint_1, 1 rad/s"):
        load_config(BridgeConfig, data, "bridge")


@pytest.mark.parametrize("part", ["arm", "tool"])
@pytest.mark.parametrize("name", ["/my_gen3", "my_gen3/", "/my_gen3/"])
def test_a_namespace_with_a_slash_of_which_no_node_would_be_believed_is_refused(part, name):
    data = load_yaml(CONFIG_FOLDER / "kinova_bridge.yaml")
    data[part]["namespace"] = name
    with pytest.raises(ConfigError, match=rf"{part}\.namespace is '{name}', allowed: my_gen3, "):
        load_config(BridgeConfig, data, "bridge")


@pytest.mark.parametrize("name", ["my_gen3", "left/my_gen3"])
def test_a_namespace_may_lie_within_another(name):
    data = load_yaml(CONFIG_FOLDER / "kinova_bridge.yaml")
    data["arm"]["namespace"] = name
    assert load_config(BridgeConfig, data, "bridge").arm.namespace == name


@pytest.mark.parametrize(("silence", "is_refused"), [(0.055, True), (0.061, False)])
def test_a_silence_within_which_a_slow_bridge_counts_as_hung_is_refused(silence, is_refused):
    data = load_yaml(CONFIG_FOLDER / "kinova_bridge.yaml")
    data["rate"], data["arm"]["period"], data["guard"]["silence"] = 50.0, 0.04, silence
    if not is_refused:
        load_config(BridgeConfig, data, "bridge")
        return
    with pytest.raises(ConfigError, match=r"guard\.silence is 0\.055, .*two rounds of rate 50 Hz"):
        load_config(BridgeConfig, data, "bridge")


@pytest.mark.parametrize("end", ["lower", "upper"])
@pytest.mark.parametrize(("joint", "planned"), [(0, "1.5"), (1, "1.5707"), (2, "1.5707")])
def test_a_tool_that_is_planned_beyond_where_the_bridge_leads_it_is_refused(
    kinova, end, joint, planned
):
    require_drivable(kinova)
    ends = list(getattr(kinova.bridge.tool, end))
    ends[joint] *= 1.3 / abs(ends[joint])
    tool = replace(kinova.bridge.tool, **{end: tuple(ends)})
    config = replace(kinova, bridge=replace(kinova.bridge, tool=tool))
    with pytest.raises(ConfigError, match=rf"limits\.pitch.*{planned}.*up to 1\.3 rad.*joint_"):
        require_drivable(config)


@pytest.mark.parametrize(("most", "is_refused"), [(1.0, False), (1.1, True)])
def test_plans_that_the_driver_cannot_keep_are_refused_at_the_start(kinova, most, is_refused):
    data = load_yaml(CONFIG_FOLDER / "kinova_limits.yaml")
    data["layers"][0]["arm_acceleration"][1] = most
    config = replace(kinova, limits=load_config(LimitsConfig, data, "limits"))
    if not is_refused:
        require_drivable(config)
        return
    with pytest.raises(ConfigError, match=r"arm_acceleration.*1.1.*of joint_2, 1 rad/s"):
        require_drivable(config)
