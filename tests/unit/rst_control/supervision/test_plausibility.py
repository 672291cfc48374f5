# SPDX-License-Identifier: BSD-3-Clause
"""Each fault of a sensor, and beside it what looks like it and is none."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.unit.rst_control.support.sensor_streams import (
    PERIOD,
    SENSORS,
    SETTINGS,
    TOOL_STEP,
    coarse,
    first_objection,
    measurements,
    pull,
    ramp,
    swing,
    watch,
)

STILL = ramp(0.0)


def from_sample(first, change, last=10**9):
    return lambda k, m: change(m) if first <= k <= last else m


def held_at(first, name, joints=slice(None)):
    """From a sample on, readings of some joints stay as they were."""
    kept = {}

    def spoil(k, m):
        if k < first:
            return m
        frozen = kept.setdefault(name, getattr(m, name).copy())
        values = getattr(m, name).copy()
        values[joints] = frozen[joints]
        return replace(m, **{name: values})

    return spoil


def stands_from(first, joints=slice(None)):
    """After a sample some joints stay as they were, and say that they rest."""
    held = held_at(first, "position", joints)

    def spoil(k, m):
        velocity = m.velocity.copy()
        velocity[joints] = 0.0 if k >= first else velocity[joints]
        return held(k, replace(m, velocity=velocity))

    return spoil


def moved(offset, joint=2):
    return lambda m: replace(m, position=m.position + offset * np.eye(10)[joint])


# Frozen


@pytest.mark.parametrize(("joints", "name"), [(slice(None), "joint_1"), (5, "joint_6")])
def test_readings_that_stay_the_same_while_the_joint_is_sent_elsewhere_are_frozen(joints, name):
    rate = 0.1
    words, time = first_objection(ramp(rate), spoil=stands_from(500, joints))
    assert f"{name} frozen or blocked" in words and "0.0" in words
    wait = SENSORS.frozen_after + SETTINGS.watchdogs.joint_state_age + SETTINGS.tension.delay
    assert time - 1.0 <= SENSORS.frozen_way / rate + wait + 0.01


def test_one_frozen_joint_with_its_velocity_going_on_is_found_at_once():
    words, time = first_objection(ramp(0.1), spoil=held_at(500, "position", 5))
    assert "joint_6" in words
    assert time < 1.1


@pytest.mark.parametrize("rate", [0.005, 0.02])
def test_frozen_joints_are_found_in_slow_motion_too_after_little_way(rate):
    words, time = first_objection(ramp(rate), seconds=4.0, spoil=stands_from(500))
    assert "frozen" in words
    assert (time - 1.0) * rate < 2 * SENSORS.frozen_way


def test_coarse_encoders_at_rest_are_not_frozen():
    assert first_objection(STILL, seconds=3.0) == ("", np.inf)


def test_coarse_encoders_in_the_slowest_motion_are_not_frozen():
    def spoil(k, m):
        return replace(m, position=np.round(m.position / TOOL_STEP) * TOOL_STEP)

    assert first_objection(ramp(0.002), seconds=3.0, spoil=spoil)[0] == ""


def test_joints_that_set_off_late_are_not_frozen():
    late = ramp(0.5, start=0.05)
    sensors = watch()
    for (measured, _), (_, setpoint) in zip(
        measurements(late, 1.0), measurements(ramp(0.5), 1.0), strict=True
    ):
        sensors.update(measured, setpoint, None)
        assert sensors.objection == ""


def test_a_frozen_joint_is_forgiven_once_its_reading_changes_and_not_before():
    sensors, stands = watch(), stands_from(100)
    for k, (measured, setpoint) in enumerate(measurements(ramp(0.05), 1.0)):
        kept = stands(k, measured)
        sensors.update(kept, setpoint, None)
    assert "frozen" in sensors.objection
    for n in range(1, 120):  # whatever is commanded, or nothing
        sensors.update(replace(kept, stamp=200 + n * 0.002, sent=None), None, None)
        assert "frozen" in sensors.objection
    other = replace(kept, position=kept.position + 1e-6, stamp=200.5)
    sensors.update(other, None, None)
    assert sensors.objection == ""


def test_a_robot_with_a_fault_of_its_own_stands_and_is_not_frozen():
    stands = stands_from(100)

    def spoil(k, m):
        fault = "set-points stopped coming while moving, 31 ms ago" if k > 100 else ""
        return replace(stands(k, m), fault=fault)

    assert first_objection(ramp(0.05), seconds=1.0, spoil=spoil)[0] == ""


# Jumping


@pytest.mark.parametrize("offset", [0.006, -0.05, 3.0])
def test_a_position_that_jumps_is_named_at_once(offset):
    words, time = first_objection(STILL, spoil=from_sample(500, moved(offset)))
    assert f"joint_3 jumped by {offset:+.4f} rad" in words and "allowed 0.0" in words
    assert time == pytest.approx(1.0)


def test_one_wrong_sample_is_named_and_forgotten_after_a_while_of_good_ones():
    sensors, objections = watch(), []
    spoil = from_sample(100, moved(0.02), last=100)
    for k, (measured, setpoint) in enumerate(measurements(STILL, 1.0)):
        sensors.update(spoil(k, measured), setpoint, None)
        objections.append(sensors.objection)
    bad = [k for k, words in enumerate(objections) if words]
    assert bad[0] == 100 and "+0.0200" in objections[100]
    assert bad[-1] - 101 == pytest.approx(SENSORS.plausible_for / 0.002, abs=1)
    assert bad == list(range(bad[0], bad[-1] + 1))


def test_a_small_jump_is_found_by_its_velocity():
    words, _ = first_objection(STILL, spoil=from_sample(500, moved(0.004)))
    assert "joint_3 positions went +0.0040 rad away from its velocities" in words


def test_a_joint_at_its_greatest_speed_does_not_jump():
    assert first_objection(ramp(1.15), seconds=0.5, spoil=coarse(np.random.default_rng(1)))[0] == ""


def test_messages_that_come_bunched_are_no_jump():
    def bunched(k, m):
        return replace(m, stamp=100.0 + 0.016 * (k // 8 + 1) + 1e-5 * (k % 8))

    assert first_objection(ramp(1.1), seconds=0.5, spoil=bunched)[0] == ""


def test_of_a_robot_that_reports_more_often_than_is_looked_the_newest_are_believed():
    def newest(k, m):  # by turns 1 ms and 3 ms after the one before
        age = 0.5 * PERIOD * (k % 2)
        return replace(m, position=m.position - age * m.velocity, sent=m.sent - age)

    assert first_objection(ramp(0.8), spoil=newest)[0] == ""


def test_messages_that_were_passed_over_are_no_jump():
    sensors = watch()
    for k, (measured, setpoint) in enumerate(measurements(ramp(1.1), 0.5)):
        if k % 7 == 0:
            sensors.update(measured, setpoint, None)
            assert sensors.objection == ""


def test_after_a_gap_the_robot_may_be_where_it_could_have_gone_and_no_further():
    def gap(offset):
        def spoil(k, m):
            return m if k < 100 else moved(offset)(replace(m, stamp=m.stamp + 1, sent=m.sent + 1))

        return first_objection(STILL, spoil=spoil)[0]

    assert gap(1.0) == ""
    assert "jumped" in gap(1.6)


# Velocities


def test_velocities_that_freeze_while_the_joint_slows_down_are_found():
    words, time = first_objection(swing(0.3), spoil=held_at(500, "velocity"))
    assert "velocities" in words and "0.2" not in words.split(",")[1]
    assert time < 1.2


@pytest.mark.parametrize("speed", [0.012, -0.1])
def test_a_robot_at_rest_that_claims_to_move_is_found(speed):
    words, _ = first_objection(
        STILL, spoil=from_sample(500, lambda m: replace(m, velocity=np.full(10, speed)))
    )
    assert f"{speed:+.3f} rad/s now" in words


@pytest.mark.parametrize("rate", [0.01, 0.3])
def test_a_robot_that_moves_and_claims_to_rest_is_found(rate):
    words, _ = first_objection(
        ramp(rate), spoil=from_sample(10, lambda m: replace(m, velocity=np.zeros(10)))
    )
    assert "velocities" in words


def test_velocities_that_are_filtered_and_noisy_are_none_the_worse():
    rng, kept = np.random.default_rng(2), np.zeros(10)

    def spoil(k, m):
        kept[:] += 0.002 / 0.015 * (m.velocity - kept)
        return replace(m, velocity=kept + rng.normal(0, 0.02, 10))

    assert first_objection(swing(0.6), seconds=3.0, spoil=spoil)[0] == ""


@settings(max_examples=5)
@given(st.integers(0, 10**6), st.floats(0.001, 1.1))
def test_good_sensors_that_are_coarse_and_noisy_are_believed(seed, rate):
    assert first_objection(swing(rate), spoil=coarse(np.random.default_rng(seed)))[0] == ""


# Clocks


def test_a_clock_that_jumps_ahead_excuses_no_jump_of_a_joint():
    def spoil(k, m):
        return moved(0.1)(replace(m, sent=m.sent + 3600.0)) if k >= 500 else m

    words, time = first_objection(STILL, spoil=spoil)
    assert "jumped by +0.1000 rad" in words
    assert time == pytest.approx(1.0)


@pytest.mark.parametrize("jump", [0.001, 0.5, 3600.0])
def test_a_clock_that_jumps_ahead_is_no_fault_of_the_joints(jump):
    spoil = from_sample(500, lambda m: replace(m, sent=m.sent + jump))
    assert first_objection(STILL, spoil=spoil)[0] == ""
    assert first_objection(ramp(0.05), spoil=spoil)[0] == ""


@pytest.mark.parametrize("jump", [-3600.0, -30.0, 0.6, 30.0])
def test_a_clock_that_is_set_is_no_fault_where_messages_may_come_late(jump):
    """What the times of arrival cannot explain is no time that joints had to move."""
    spoil = from_sample(500, lambda m: replace(m, sent=m.sent + jump))
    assert first_objection(ramp(0.8), spoil=spoil, joint_state_age=0.5)[0] == ""


def test_a_robot_that_was_lost_may_come_back_anywhere():
    sensors = watch()
    pairs = list(measurements(STILL, 0.1))
    for k, (measured, setpoint) in enumerate(pairs):
        lost = replace(measured, connected=False) if 20 <= k < 30 else measured
        sensors.update(moved(0.5)(lost) if k >= 20 else lost, setpoint if k < 20 else None, None)
        assert sensors.objection == ""


# Tension


def test_a_tension_that_stays_the_same_while_tissue_is_pulled_is_stuck():
    words, s = pull(lambda s: min(200.0 * s, 0.4))
    assert "tension stuck: it reads 0.4000 N" in words and "mm of pull, allowed 0.50 mm" in words
    assert s < 0.002 + SENSORS.tension_frozen_way + 0.002


def test_a_tension_of_a_coarse_sensor_on_soft_tissue_is_not_stuck():
    assert pull(lambda s: round(20.0 * s / 0.005) * 0.005, seconds=0.9, speed=0.02)[0] == ""


def test_a_tension_that_stays_the_same_while_nothing_is_pulled_is_not_stuck():
    def spoil(k, m):
        return replace(m, force=np.array([0.5, 0.0, 0.0]), gripped=True)

    assert first_objection(STILL, seconds=1.0, spoil=spoil)[0] == ""


@pytest.mark.parametrize("spike", [1.2, -0.7])
def test_a_tension_that_jumps_is_named(spike):
    words, s = pull(lambda s: 300.0 * s + spike * (s >= 0.004))
    assert "tension jumped by" in words and "sensor faulty, or tissue torn" in words
    assert s == pytest.approx(0.004, abs=1e-4)


def test_the_stiffest_tissue_at_full_speed_is_no_jump():
    assert pull(lambda s: 4000.0 * s, speed=0.02, seconds=0.2)[0] == ""


def test_a_tension_that_drops_as_the_jaws_let_go_is_no_jump():
    sensors = watch()
    for k, (measured, setpoint) in enumerate(measurements(STILL, 0.2)):
        force = np.array([0.0, 0.0, -2.0 if k < 50 else 0.0])
        sensors.update(replace(measured, force=force, gripped=k < 50), setpoint, 0.004)
        assert sensors.objection == "" or "stuck" in sensors.objection


def test_a_sensor_that_never_says_anything_is_found_before_much_pull():
    words, s = pull(lambda s: 0.001, seconds=2.0)
    assert "tension 0.001 N after 10.0 mm of pull, at least 0.05 N expected" in words
    assert s == pytest.approx(SENSORS.slack_way, abs=1e-4)


def test_slack_tissue_that_becomes_taut_is_no_dead_sensor():
    assert pull(lambda s: 200.0 * max(0.0, s - 0.009), seconds=1.5)[0] == ""


def test_a_tension_with_the_wrong_sign_is_the_same_tension():
    right = pull(lambda s: 200.0 * s, seconds=0.5)
    assert right == pull(lambda s: -200.0 * s, seconds=0.5) == ("", np.inf)
