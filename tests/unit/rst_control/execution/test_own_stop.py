# SPDX-License-Identifier: BSD-3-Clause
"""After the robot stopped by itself in a pull, the next motion sets off from where it holds."""

import numpy as np
import pytest

from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.planning.plan import PhaseKind
from rst_control.types import State
from tests.unit.rst_control.support.executor_rig import PERIOD, Rig

ARM = 8  # joints, with the tool's pitch; the others are the jaws
BESIDE = np.array([0.0, 4e-4, 0.0, -6e-4, 0.0, 3e-4, 0.0, 1e-3, 5e-4])  # [rad] off the pull's path
STOPS = [(5e-4, 0.0), (-5e-4, 0.0), (2e-3, -1.0)]  # [m] short, and times BESIDE


def pulling():
    rig = Rig(stiffness=100.0).awake()
    rig.finish("tense")
    rig.say("pull more")
    return rig.run(0.1)


def after_a_stop():
    rig = pulling()
    rig.say("stop")
    rig.rest().say("hey robot")
    return rig.run(0.1)


def after_its_own_stop(short, beside, is_reported=True):
    """Held that far short of the last set-point and beside the path, as the robot says or not."""
    rig = pulling()
    rig.robot.fault = "set-points stopped coming while moving"
    rig.robot.hold()
    rig.rest()
    grasp, opening = rig.view.grasp, planning_joints(rig.robot.measured_js().position)[1]
    place = robot_joints(grasp.pull.evaluate(grasp.s - short).q + beside * BESIDE, opening)
    rig.robot.push(place - rig.robot.measured_js().position)
    rig.robot.hold()
    rig.robot.sent_to = place if is_reported else None
    rig.run(0.3).say("hey robot")
    rig.run(0.1)
    np.testing.assert_allclose(rig.joints, place, atol=1e-12)
    return rig


def largest_steps(rig, words):
    """Of the arm in a tick, in all and beyond what its velocities say [rad]."""
    first = len(rig.sent) - 1
    rig.finish(words)
    sent = [point for point in rig.sent[first:] if point is not None]
    steps = np.diff([point.position[:ARM] for point in sent], axis=0)
    speeds = np.array([point.velocity[:ARM] for point in sent])
    unsaid = steps - 0.5 * PERIOD * (speeds[1:] + speeds[:-1])
    return np.abs(steps).max(), np.abs(unsaid).max()


@pytest.mark.parametrize("words", ["pull less", "pull more", "release"])
def test_no_joint_steps_further_in_a_tick_than_after_a_stop_by_voice(words):
    usual = largest_steps(after_a_stop(), words)
    for short, beside, is_reported in ((5e-4, 0.0, True), (3e-4, 1.0, False)):
        rig = after_its_own_stop(short, beside, is_reported)
        most, unsaid = largest_steps(rig, words)
        assert most <= 1.1 * usual[0]
        assert unsaid <= 2.0 * usual[1] + 1e-7


@pytest.mark.parametrize(("short", "beside"), STOPS)
def test_the_tissue_is_eased_from_where_it_is(short, beside):
    """The way onto the path pulls it no harder."""
    rig = after_its_own_stop(short, beside)
    before, felt = rig.view.tension, []
    pending = rig.say("pull less")
    while not pending.ended.done():
        rig.tick()
        felt.append(rig.view.tension)
    assert pending.ended.result(0).kind == "succeeded"
    assert max(felt) <= before + 1e-3
    assert felt[-1] == pytest.approx(before - 0.25, abs=0.03)
    assert rig.view.pulled == pytest.approx(rig.view.path_position, abs=1e-5)


def test_no_tension_is_too_high_to_go_back_onto_the_path_and_ease():
    rig = after_its_own_stop(3e-4, 1.0)
    rig.robot.tissue.stiffness = 260.0
    rig.run(0.1)
    assert rig.view.tension > rig.config.controller.tension.limit
    rig.finish("pull less")
    assert rig.view.tension == pytest.approx(2.0, abs=0.03)


def test_on_the_way_to_pull_more_the_tension_is_watched():
    rig = after_its_own_stop(3e-4, 1.0).believing()
    rig.say("pull more")
    assert len(rig.view.plan.phases) == 2 and rig.view.path is not rig.view.grasp.pull
    rig.robot.tissue.stiffness = 260.0
    rig.run(2.0 * PERIOD)
    assert rig.state is not State.MOVING
    assert "allowed 2.40 N" in rig.view.mode.reason


@pytest.mark.parametrize("words", ["pull more", "pull less", "release"])
def test_after_a_stop_by_voice_the_motion_goes_on_where_it_was(words):
    rig = after_a_stop()
    grasp = rig.view.grasp
    rig.say(words)
    kinds = [PhaseKind.OPEN, PhaseKind.EASE, PhaseKind.EASE]
    phases = rig.view.plan.phases
    assert [p.kind for p in phases] == (kinds if words == "release" else [PhaseKind.STEP])
    phase = phases[1 if words == "release" else 0]
    assert phase.path is grasp.pull and phase.start == grasp.s


def test_far_from_where_it_was_the_pull_is_planned_anew_and_tissue_can_be_released():
    rig = after_its_own_stop(6e-3, 0.0)
    assert "allowed" in rig.refused("pull less")
    rig.finish("release")
    assert not rig.view.is_tissue_held


@pytest.mark.parametrize("words", ["pull more", "pull less", "release"])
def test_a_stop_on_the_way_onto_the_path_forgets_no_pull(words):
    rig = after_its_own_stop(3e-4, 1.0)
    pulled = rig.view.grasp.s
    rig.say(words)
    rig.run(2.0 * PERIOD)
    assert rig.view.path is not rig.view.grasp.pull
    rig.stop()
    rig.rest().say("hey robot")
    rig.run(0.1)
    assert rig.view.grasp.s == pytest.approx(pulled, abs=1e-3)
    rig.finish("pull less")
    assert rig.view.grasp.s < pulled
