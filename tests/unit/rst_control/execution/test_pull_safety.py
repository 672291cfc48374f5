# SPDX-License-Identifier: BSD-3-Clause
"""Whatever goes wrong during a pull, the tissue feels no more than its limit."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.assembly import make_trocar_context
from rst_control.types import State
from tests.support.changed_settings import changed
from tests.support.fake_robot import FakeRobot
from tests.unit.rst_control.support.executor_rig import Rig, shared

STIFFNESSES = [80.0, 600.0, 4000.0]


def reading(rig, tension):
    """Let the sensor read this from now on [N], whatever the tissue feels."""
    along = -rig.robot.tissue.force(rig.joints)
    force = tension * along / np.linalg.norm(along)
    rig.robot.measured_js = lambda: replace(FakeRobot.measured_js(rig.robot), force=force)


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
    assert pending.ended.result(0).kind == "failed"
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


def pulled_to_a_tension():
    rig = Rig(80.0).awake()
    rig.say("tense", tension=1.0)
    rig.until(lambda: rig.phase == "pull" and rig.view.path_position > 0.008)
    assert rig.view.tension < 0.9
    return rig


@pytest.mark.parametrize(("words", "sign"), [("pull more", 1.0), ("pull less", -1.0)])
def test_a_step_in_millimetres_during_a_pull_to_a_tension_counts_from_the_tip(words, sign):
    rig = pulled_to_a_tension()
    begin = rig.view.path_position
    rig.finish(words, distance=0.002)
    assert rig.view.path_position == pytest.approx(begin + sign * 0.002, abs=2e-4)


def test_a_step_in_millimetres_during_another_counts_from_where_that_one_ends():
    rig = pulled_to_a_tension()
    begin = rig.view.path_position
    rig.say("pull less", distance=0.002)
    rig.run(0.1)
    assert rig.view.is_moving
    rig.finish("pull less", distance=0.001)
    assert rig.view.path_position == pytest.approx(begin - 0.003, abs=2e-4)


def test_verification_takes_the_tissue_as_pulled_as_far_as_the_grasp_says():
    rig = pulled_to_a_tension()
    situation = rig.view.situation(rig.now)
    assert situation.grasp.s == rig.view.path_position
    assert situation.pulled == pytest.approx(situation.grasp.s, abs=1e-6)
    rig.say("pull less", distance=0.002)
    rig.run(0.1)
    later = rig.view.situation(rig.now)
    assert later.grasp.s == pytest.approx(situation.grasp.s - 0.002, abs=2e-4)
    assert later.pulled == pytest.approx(later.grasp.s, abs=1e-6)


def test_faults_and_pushes_lengthen_no_pull():
    """A pull that is planned anew goes on from the grasp, not from where it was planned."""
    rig = Rig(30.0).awake()
    rig.finish("tense", tension=0.6)
    most = rig.config.scene.max_displacement
    for sign in (1.0, -1.0):
        rig.robot.fault = "driver fault"
        rig.run(0.1)
        push = np.zeros(10)
        push[7] = sign * 0.004  # [rad]: the grasp is no longer where it was remembered
        rig.robot.push(push)
        rig.run(0.2)
        rig.say("hey robot")
        rig.run(1.0)
        while (pending := rig.give("pull more", distance=0.004)).reply.result(0).accepted:
            rig.until(pending.ended.done)
        assert "allowed 0 to 30.0 mm" in pending.reply.result(0).message
    assert most - 0.004 < rig.view.pulled <= most
    assert felt(rig) <= 30.0 * most


@pytest.mark.parametrize("first", [None, 1.3, 1.6])  # [N]
def test_a_pull_with_an_outlying_first_reading_is_watched_like_any_other(first):
    rig = Rig(100.0).awake().believing()
    rig.finish("tense")
    pending = rig.verified("pull more")
    reading(rig, first or rig.view.tension)
    rig.tick()
    assert pending.reply.result(0).accepted and rig.state is State.MOVING
    del rig.robot.measured_js
    rig.run(0.1)
    assert rig.state is State.MOVING and rig.view.motion.path_speed > 0.0
    reading(rig, 2.6)
    rig.tick()
    assert rig.state is not State.MOVING
    assert "tension 2.60 N" in rig.view.mode.reason and "allowed 2.40 N" in rig.view.mode.reason


def test_no_tension_stops_an_easing_motion():
    rig = Rig(100.0).awake()
    rig.finish("tense")
    rig.robot.tissue.stiffness = 260.0
    rig.run(0.1)
    assert rig.view.tension > rig.config.controller.tension.limit
    rig.finish("pull less")
    assert felt(rig) == pytest.approx(rig.config.controller.tension.maximum, abs=0.03)


@pytest.mark.parametrize(("step", "relaxed"), [(0.1, 0.78), (0.2, 0.72), (0.4, 0.9)])
def test_pull_less_never_pulls_on_though_the_tissue_relaxed_within_the_tolerance(step, relaxed):
    config = changed(shared()[0], tension={"tolerance": 0.15, "noise": 0.1})
    rig = Rig(config=config, stiffness=100.0, context=make_trocar_context(config, shared()[1]))
    rig.awake().finish("tense")
    rig.believing()
    rig.robot.tissue.stiffness *= relaxed / felt(rig)
    rig.run(0.5)
    place = furthest = rig.view.grasp.s
    pending = rig.say("pull less", tension=step)
    assert pending.reply.result(0).accepted
    while not pending.ended.done():
        rig.tick()
        furthest = max(furthest, rig.view.grasp.s)
    assert furthest <= place + 1e-5
