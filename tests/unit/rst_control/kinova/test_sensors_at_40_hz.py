# SPDX-License-Identifier: BSD-3-Clause
"""The sensor checks with the settings for the real robot: 40 states a second, 70 ms late."""

from dataclasses import replace

import numpy as np
import pytest

from bench.kinova.rig import kinova_motion
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.supervision.plausibility import SensorWatch, max_joint_speed
from rst_control.types import Measurement

CONFIG = kinova_motion()
PERIOD, LATE = 0.025, 0.070  # [s]
COUNTS = np.repeat([1e-4, 2.0 * np.pi / 4096], [7, 3])  # [rad] of the encoders


def states(rate, seconds, spoil=lambda k, m: m, jaws=None, gripped=False, late=lambda k: 0.0):
    """Measurements of joints that swing at up to `rate` [rad/s], with their set-points.

    The driver's k-th message comes to the bridge `late(k)` [s] after its time.
    """
    rng = np.random.default_rng(3)

    def at(time):
        t = max(0.0, time - 0.5)
        place = np.full(10, 0.2 + rate / 3.0 * (1.0 - np.cos(3.0 * t)))
        speed = np.full(10, rate * np.sin(3.0 * t))
        if jaws is not None:
            opens = (jaws(time) - jaws(time - 1e-3)) / 1e-3
            place, speed = robot_joints(place[:9], jaws(time)), robot_joints(speed[:9], opens)
        return place, speed

    for k in range(round(seconds / PERIOD)):
        time = k * PERIOD
        position, velocity = at(time - LATE)
        position = COUNTS * np.round(position / COUNTS)
        made = Measurement(
            position=position,
            velocity=velocity + rng.normal(0.0, 1e-3, 10),
            effort=np.zeros(10),
            stamp=100.0 + time + rng.uniform(0.0, 0.008) + late(k),
            sent=5e8 + time + late(k),  # the bridge stamps them as they come
            gripped=gripped,
        )
        yield spoil(k, made), at(time)[0]


def objection(stream):
    watch = SensorWatch(CONFIG.controller, max_joint_speed(CONFIG.limits))
    for measured, setpoint in stream:
        watch.update(measured, setpoint, None)
        if watch.objection:
            return watch.objection
    return ""


def with_positions(m, joints, values):
    """The same states, but for where some joints are [rad]."""
    position = m.position.copy()
    position[joints] = values
    return replace(m, position=position)


@pytest.mark.parametrize("rate", [0.0, 0.001, 0.01, 0.1, 0.4])
def test_good_states_are_believed(rate):
    assert objection(states(rate, 10.0)) == ""


@pytest.mark.parametrize("rate", [0.1, 0.4])
@pytest.mark.parametrize("late", [0.008, 0.016, 0.024])
def test_a_state_that_the_network_holds_up_is_no_fault(rate, late):
    assert objection(states(rate, 10.0, late=lambda k: late * (k % 5 == 3))) == ""


def test_states_that_are_lost_now_and_then_are_no_fault():
    stream = list(states(0.3, 10.0))
    assert objection(pair for k, pair in enumerate(stream) if k % 7 and k % 11) == ""


@pytest.mark.parametrize("joint", [0, 6, 7])
@pytest.mark.parametrize("rate", [0.02, 0.3])
def test_a_joint_that_freezes_is_named(rate, joint):
    held = []

    def spoil(k, m):
        if k < 60:
            held[:] = [m.position[joint]]
        return with_positions(m, joint, held[0])

    name = ["joint_1", "joint_7", "joint_pitch"][[0, 6, 7].index(joint)]
    assert name in objection(states(rate, 10.0, spoil))


def test_a_joint_that_jumps_is_named():
    def spoil(k, m):
        return with_positions(m, 2, m.position[2] + 0.06 * (k >= 100))

    assert "joint_3 jumped" in objection(states(0.1, 5.0, spoil))


def test_velocities_that_contradict_the_positions_are_found():
    def spoil(k, m):
        return replace(m, velocity=m.velocity * (k < 100))

    assert "away from its velocities" in objection(states(0.2, 6.0, spoil))


def closing(opening, rate):
    """Jaws that close at a rate [rad/s] from 0.2 rad to an opening [rad]."""
    return lambda time: max(opening, 0.2 - rate * max(0.0, time - 0.5))


def astray(seconds, jaws, sent):
    """States of jaws, with the set-points of jaws that were sent elsewhere."""
    both = states(0.0, seconds, jaws=jaws), states(0.0, seconds, jaws=sent)
    return [(m, setpoint) for (m, _), (_, setpoint) in zip(*both, strict=True)]


@pytest.mark.parametrize("rate", [0.02, 0.045, 0.45])
def test_jaws_that_tissue_keeps_open_are_not_frozen_however_slowly_they_close(rate):
    pairs = astray(14.0, closing(0.04, rate), closing(0.0, rate))
    assert planning_joints(pairs[-1][0].position)[1] > planning_joints(pairs[-1][1])[1] + 0.03
    assert objection(pairs) == ""


def test_jaws_that_do_not_open_are_found():
    pairs = astray(6.0, lambda time: 0.1, lambda time: 0.1 + 0.2 * max(0.0, time - 1.0))
    assert "joint_finger" in objection(pairs)


def test_jaws_that_freeze_while_the_wrist_turns_are_found_with_tissue_between_them_too():
    stuck = states(
        *(0.1, 8.0, lambda k, m: with_positions(m, slice(8, None), 0.02)),
        jaws=lambda time: 0.0,
        gripped=True,
    )
    assert "joint_finger" in objection(stuck)
