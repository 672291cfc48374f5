# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.registration import shaft_poses
from rst_control.registration.pivot_calibration import TooFewPoses, TooLittleSpread
from rst_control.registration.shaft_poses import ShaftPoses, fit_words
from tests.unit.rst_control.support.executor_rig import Rig

SHIFTS = [(0.0, 0.0), (0.03, 0.0), (-0.03, 0.0), (0.0, 0.03), (0.0, -0.03), (0.02, 0.02)]


@pytest.fixture(scope="module")
def tilted(planner, home):
    """Robot joints in which the shaft goes through the trocar every which way."""
    poses = []
    for x, y in SHIFTS:
        goal = Configuration(planner.model, home).T_base_tip
        goal[:3, 3] = planner.centre + np.array([x, y, 0.0])
        poses.append(robot_joints(planner.leg(home, goal).end, 0.0))
    return poses


@pytest.fixture
def poses(robot, motion_config):
    return ShaftPoses(robot, motion_config.rcm, motion_config.controller.watchdogs)


def record(poses, joints, **changes):
    """Record where a robot at rest in standby stands; returns the answer."""
    rig = Rig()
    rig.robot.push(joints - rig.robot.measured_js().position)
    rig.run(0.01)
    view = rig.view
    if changes:
        view = replace(view, measurement=replace(view.measurement, **changes))
    return poses.record(view, rig.now)


def test_recorded_poses_are_counted_and_give_the_trocar(poses, tilted, planner):
    for n, joints in enumerate(tilted, 1):
        assert record(poses, joints).message == f"{n} shaft poses recorded, 5 needed"
    fit = poses.fit()
    np.testing.assert_allclose(fit.position, planner.trocar, atol=1e-8)
    assert poses.objection(fit) == ""
    words = fit_words(fit)
    assert "(0.406000, -0.024000, 0.415000) m from 6 shaft poses" in words
    assert "residual 0.000 mm rms" in words
    assert "contradict" not in words


def test_poses_are_needed_and_can_be_forgotten(poses, tilted):
    for joints in tilted:
        record(poses, joints)
    assert poses.forget().message == "6 shaft poses forgotten"
    with pytest.raises(TooFewPoses, match="0 shaft poses recorded, allowed 5 and more"):
        poses.fit()


def test_the_same_pose_again_is_no_calibration(poses, tilted):
    for _ in range(6):
        record(poses, tilted[0])
    with pytest.raises(TooLittleSpread):
        poses.fit()


def test_a_moving_robot_is_not_recorded(poses, tilted):
    velocity = np.full(10, 0.02)
    refusal = record(poses, tilted[0], velocity=velocity)
    assert not refusal.accepted and "not at rest" in refusal.message
    rig = Rig().moving("reach")
    assert "moving" in poses.record(rig.view, rig.now).message
    with pytest.raises(TooFewPoses, match="0 shaft"):
        poses.fit()


def test_a_robot_that_says_nothing_is_not_recorded(poses):
    rig = Rig().run(0.01)
    assert poses.record(rig.view, rig.now + 0.05).message == "joint states 50 ms old, allowed 20 ms"
    rig.robot.measured_js = lambda: None
    silent = Rig()
    assert poses.record(silent.view, silent.now).message == "robot not connected"


IN_USE = "arm_in_use: somebody else controls the arm"


@pytest.mark.parametrize(
    ("fault", "aside", "is_recorded"),
    [(IN_USE, 0.0, True), (IN_USE, 0.05, False), ("arm_fault: it met something", 0.0, False)],
)
def test_an_arm_that_was_guided_by_hand_is_recorded_at_rest_alone(
    poses, tilted, fault, aside, is_recorded
):
    rig = Rig()
    rig.robot.push(tilted[0] - rig.robot.measured_js().position)
    rig.robot.fault = fault
    rig.run(0.01)
    assert rig.view.health is not None
    moving = replace(rig.view.measurement, velocity=np.full(10, aside))
    reply = poses.record(replace(rig.view, measurement=moving), rig.now)
    assert reply.accepted is is_recorded, reply.message
    assert not poses.record(rig.view, rig.now + 0.05).accepted


def test_no_more_poses_are_kept_than_there_is_room_for(poses, tilted, monkeypatch):
    monkeypatch.setattr(shaft_poses, "MOST", 2)
    assert record(poses, tilted[0]).accepted and record(poses, tilted[1]).accepted
    assert record(poses, tilted[2]).message == "2 shaft poses recorded already; fit or forget them"


def test_a_pose_beside_the_others_is_named_and_the_fit_is_not_to_be_set(poses, tilted):
    for joints in [*tilted, *tilted]:
        record(poses, joints)
    bad = tilted[3].copy()
    bad[1] += 0.02
    record(poses, bad)
    fit = poses.fit()
    assert fit.outliers == (12,)
    assert "poses that contradict the others: 13" in fit_words(fit)
    assert "shaft pose 13 is" in poses.objection(fit)
    assert "allowed 1.000 mm" in poses.objection(fit)


def test_a_point_that_is_known_too_badly_is_not_to_be_set(poses, tilted):
    for joints in tilted:
        record(poses, joints)
    fit = replace(poses.fit(), covariance=np.diag([0.0, 0.0, 4e-6]))
    assert "standard deviation of the common point is 2.000 mm, allowed 1.000 mm" in (
        poses.objection(fit)
    )
