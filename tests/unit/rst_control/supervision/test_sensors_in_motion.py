# SPDX-License-Identifier: BSD-3-Clause
"""Sensors that fail in the running executor: held, named; and good ones that are left alone."""

import re
from dataclasses import replace

import numpy as np
import pytest

from rst_control.types import State
from tests.support.changed_settings import changed
from tests.unit.rst_control.support.executor_rig import Rig, shared
from tests.unit.rst_control.support.sensor_streams import SENSORS, STEPS, coarse


def spoil(rig, change):
    """Let every measurement from now on go through `change`; returns how to end that."""
    measured_js = rig.robot.measured_js
    rig.robot.measured_js = lambda: change(measured_js())

    def end():
        rig.robot.measured_js = measured_js

    return end


def frozen(rig, *names):
    """Fresh stamps on old numbers."""
    old = rig.robot.measured_js()
    return lambda m: replace(m, **{name: getattr(old, name) for name in names})


FAULTS = {
    "all frozen": (
        "reach",
        lambda rig: frozen(rig, "position", "velocity"),
        "frozen|velocities",
    ),
    "positions frozen": ("pull", lambda rig: frozen(rig, "position"), "velocities"),
    "velocities frozen": ("reach", lambda rig: frozen(rig, "velocity"), "velocities"),
    "one joint off": (
        "reach",
        lambda rig: lambda m: replace(m, position=m.position + 0.01 * np.eye(10)[3]),
        "joint_4 jumped",
    ),
    "tension stuck": ("pull", lambda rig: frozen(rig, "force"), "tension (stuck|rose)"),
    "tension jumps": (
        "pull",
        lambda rig: lambda m: replace(m, force=m.force * 3.0 + 0.6),
        "tension jumped",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_each_brakes_along_the_path_and_is_named(name):
    phase, change, words = FAULTS[name]
    rig = Rig().moving(phase)
    spoil(rig, change(rig))
    first, started = len(rig.sent), rig.view.path_position
    rig.until(lambda: rig.state is not State.MOVING, limit=2.0)
    went = rig.view.path_position - started
    rig.rest()
    sent = [s for s in rig.sent[first:] if s is not None]
    assert max(rig.rcm(s.position) for s in sent) < 1e-6
    assert went < 5e-3 or name == "velocities frozen"  # true for as long as the speed stays
    reasons = [entry.message for entry in rig.executor.events if entry.kind == "at_rest"]
    assert re.search(words, reasons[-1])


def test_nothing_goes_on_while_the_sensors_lie_nor_after_until_hey_robot():
    rig = Rig().moving("reach")
    rng = np.random.default_rng(1)
    end = spoil(rig, lambda m: replace(m, position=m.position + rng.choice([0.0, 0.05])))
    rig.until(lambda: rig.state is State.FAULTED, limit=1.0)
    assert re.search(r"sensor fault: joint_\d jumped by .0.05", rig.view.mode.reason)
    assert "sensor fault" in rig.refused("hey robot")
    end()
    assert rig.state is State.FAULTED
    before = rig.robot.measured_js().position
    rig.run(2 * SENSORS.plausible_for)
    assert rig.state is State.FAULTED and rig.view.health is None
    np.testing.assert_array_equal(rig.robot.measured_js().position, before)
    rig.say("hey robot")
    assert rig.state is State.ACTIVE
    assert rig.still_for(0.1)


def test_a_motion_at_a_millimetre_a_second_on_a_frozen_robot_ends_within_two_millimetres():
    rig = Rig(config=changed(shared()[0], speed={"tip_speed": 1e-3})).awake()
    rig.say("tense")
    rig.until(lambda: rig.phase == "reach" and rig.view.path_position > 2e-4)
    spoil(rig, frozen(rig, "position", "velocity"))
    started = rig.view.path_position
    rig.until(lambda: rig.state is not State.MOVING, limit=3.0)
    assert rig.view.path_position - started < 2e-3


@pytest.mark.parametrize("kind", ["exact", "coarse and noisy"])
def test_a_whole_session_with_good_sensors_raises_nothing(kind):
    rig = Rig()
    if kind != "exact":  # arm and tool with encoders, velocities and tension as real ones are
        rough, rng = coarse(np.random.default_rng(3), STEPS, 1e-3), np.random.default_rng(4)

        def noisy(m):
            force = m.force + rng.normal(0.0, 0.003, 3)
            return replace(rough(0, m), force=np.round(force / 0.002) * 0.002)

        spoil(rig, noisy)
    rig.awake()
    for words in ("tense", "pull more", "pull less", "release"):
        rig.finish(words)
    assert rig.state is State.ACTIVE and rig.view.health is None
