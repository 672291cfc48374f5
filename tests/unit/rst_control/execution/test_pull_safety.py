# SPDX-License-Identifier: BSD-3-Clause
"""Whatever goes wrong during a pull, the tissue feels no more than its limit."""

import numpy as np
import pytest

from rst_control.types import State
from tests.unit.rst_control.support.executor_rig import Rig

STIFFNESSES = [80.0, 600.0, 4000.0]


def felt(rig):
    """What the tissue truly feels [N], whatever the sensor says."""
    return float(np.linalg.norm(rig.robot.tissue.force(rig.joints)))


def pulling(stiffness, tension):
    rig = Rig(stiffness).awake()
    pending = rig.say("tense", tension=2.0)
    rig.until(lambda: rig.phase == "pull" and felt(rig) > tension)
    return rig, pending


def most_felt(rig, seconds):
    most = felt(rig)
    for _ in range(round(seconds / 0.002)):
        rig.tick()
        most = max(most, felt(rig))
    return most


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("tension", [0.3, 1.0, 1.8])
def test_states_that_stop_coming_end_the_pull_below_the_limit(stiffness, tension):
    rig, pending = pulling(stiffness, tension)
    rig.robot.freeze()
    assert most_felt(rig, 0.5) < rig.config.controller.tension.limit
    assert rig.state is State.FAULTED
    assert "stale" in pending.ended.result(0).message


@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_a_tension_that_stays_as_it_was_fails_the_command_and_leaves_the_robot_ready(stiffness):
    rig, pending = pulling(stiffness, 1.0)
    rig.believing()  # whatever the watch over the sensors would make of it
    true, dead = rig.robot.tissue, rig.robot.tissue.force(rig.joints)

    class DeadSensor:
        is_held = True
        force = staticmethod(lambda _: dead)

    rig.robot.tissue = DeadSensor()
    rig.until(lambda: rig.state is State.ACTIVE)
    rig.robot.tissue = true
    assert felt(rig) < rig.config.controller.tension.limit
    assert "sensor dead" in pending.ended.result(0).message
    assert pending.ended.result(0).kind == "failed"


@pytest.mark.parametrize("stiffness", [600.0, 2000.0, 4000.0])
def test_a_step_in_millimetres_ends_at_the_highest_tension_allowed(stiffness):
    rig = Rig(stiffness).awake()
    rig.finish("tense", tension=0.3)
    step = 0.9 * (2.0 - 0.3) / stiffness if stiffness < 1000.0 else 0.002
    pending = rig.say("pull more", distance=step)
    most = 0.0
    while not pending.ended.done():
        rig.tick()
        most = max(most, felt(rig))
    expected = min(0.3 + stiffness * step, rig.config.controller.tension.maximum)
    assert most <= 1.02 * expected
    assert felt(rig) == pytest.approx(expected, abs=0.02)


def test_a_step_in_millimetres_on_soft_tissue_goes_exactly_so_far():
    rig = Rig(100.0).awake()
    rig.finish("tense", tension=0.5)
    before = rig.view.path_position
    rig.finish("pull more", distance=0.003)
    assert rig.view.path_position - before == pytest.approx(0.003, abs=2e-6)
    assert rig.view.tension_target == 0.0  # placed by distance: no tension to hold
