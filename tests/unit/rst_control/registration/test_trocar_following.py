# SPDX-License-Identifier: BSD-3-Clause
"""A robot that follows its trocar: exact towards the moving trocar, at rest for the controller."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.admission.command_queue import CommandQueue
from rst_control.assembly import make_executor
from rst_control.kinematics.configuration import Configuration, planning_joints, robot_joints
from rst_control.kinematics.rcm import rcm_state
from rst_control.registration.tracked_place import Report
from rst_control.registration.trocar import TrocarRegistrar
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.registration.trocar_following import TrocarFollowing
from rst_control.types import Reason, Setpoint, State
from tests.support.changed_settings import changed
from tests.support.fake_robot import FakeRobot
from tests.unit.rst_control.support.executor_rig import PERIOD, Rig, shared

MOST = 1e-4  # [m] of the shaft from the trocar while it breathes


def following_settings():
    config = shared()[0]
    trocar = replace(config.controller.tracking.trocar, motion="followed")
    return changed(config, tracking={"trocar": trocar})


class FollowingRig(Rig):
    """A rig whose trocar breathes, with a tracker at 50 Hz."""

    def __init__(self, amplitude=0.0025):
        super().__init__(config=following_settings())
        self.amplitude, self.is_tracked, self.jump = amplitude, True, np.zeros(3)
        self.home = np.array(self.config.scene.trocar)
        self.true_robot = self.robot
        self.robot, self.errors = self.followed(), []

    def followed(self):
        pose, model = self.context.trocar_pose, shared()[1]
        state = lambda: self.executor.snapshot.mode.state  # noqa: E731
        return TrocarFollowing(self.true_robot, self.config, model, state, pose)

    def restart(self):
        """The controller, alone, is started anew."""
        self.context = ActiveTrocarContext(self.context.current)
        clear = self.true_robot.clear_fault
        self.executor = make_executor(self.config, self.context, clear, self.liveness)
        self.queue = CommandQueue(self.executor, self.context.verify, lambda: self.now)
        self.robot = self.followed()
        return self

    def trocar(self):
        phase = 2.0 * np.pi * 0.25 * (self.now - 10.0)
        return self.home + np.array([self.amplitude * (1.0 - np.cos(phase)), 0.0, 0.0]) + self.jump

    def tick(self):
        if self.is_tracked and round(self.now / PERIOD) % 10 == 0:
            self.robot.take(Report(self.trocar(), self.now))
        setpoint = super().tick()
        q, _ = planning_joints(self.true_robot.measured_js().position)
        self.errors.append(rcm_state(Configuration(shared()[1], q), self.trocar()).error)
        return setpoint


@pytest.fixture
def rig():
    """Active for a second, the shaft in the breathing trocar."""
    return FollowingRig().run(0.3).awake().run(1.0)


def test_the_shaft_stays_in_a_trocar_that_breathes_at_rest_and_in_motion(rig):
    rig.errors.clear()
    rig.run(4.0)  # a breath, at rest
    rig.finish("tense")
    assert max(rig.errors) < MOST


def test_without_following_it_is_as_far_off_as_the_trocar_goes():
    rig = FollowingRig()
    rig.run(2.0)  # half a breath; in standby nothing moves
    assert max(rig.errors) > 0.004


def test_the_controller_sees_a_robot_at_rest(rig):
    before = rig.view.measurement.position
    rig.run(2.0)
    np.testing.assert_allclose(rig.view.measurement.position, before, atol=1e-3)
    assert np.abs(rig.view.measurement.velocity).max() < 2e-3


@pytest.mark.parametrize("words", ["stop", "terminate"])
def test_stop_and_terminate_end_it(rig, words):
    rig.say(words)
    rig.run(0.3)
    still = rig.true_robot.measured_js().position
    rig.run(1.0)
    np.testing.assert_allclose(rig.true_robot.measured_js().position, still, atol=1e-9)


def test_after_a_stop_it_goes_on_from_where_it_was(rig):
    rig.say("stop")
    rig.run(1.0)
    before = rig.true_robot.measured_js().position
    rig.awake()
    joints = [before]
    for _ in range(500):
        rig.tick()
        joints.append(rig.true_robot.measured_js().position)
    speeds = np.abs(np.diff(joints, axis=0)).max() / PERIOD
    assert 0.0 < speeds < 0.5  # no jump
    rig.errors.clear()
    rig.run(1.0)
    assert max(rig.errors) < MOST


@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        (lambda rig: setattr(rig, "is_tracked", False), Reason.TRACKER_STALE),
        (lambda rig: setattr(rig, "jump", np.array([0.0, 0.006, 0.0])), Reason.TRACKER_JUMPED),
        (lambda rig: setattr(rig, "amplitude", 0.006), Reason.TRACKER_TOO_FAR),
    ],
)
@pytest.mark.parametrize("moving", [False, True])
def test_a_tracker_that_is_not_believed_brakes_and_latches(fault, reason, moving):
    rig = FollowingRig()
    rig.run(0.3).awake()
    if moving:
        rig.say("tense")
        rig.run(0.5)
    if reason is Reason.TRACKER_TOO_FAR:  # it breathes deeper from a breath's end on
        rig.until(lambda: np.linalg.norm(rig.trocar() - rig.home) < 1e-5)
    fault(rig)
    rig.until(lambda: rig.state is State.FAULTED, limit=5.0)
    assert rig.view.latch.reason is reason
    still = rig.true_robot.measured_js().position
    rig.run(0.5)
    np.testing.assert_allclose(rig.true_robot.measured_js().position, still, atol=1e-6)


def test_without_a_tracker_nothing_begins():
    rig = FollowingRig()
    rig.is_tracked = False
    rig.run(0.1)
    assert "no trocar was tracked yet" in rig.refused("hey robot")


def test_a_joint_that_reads_the_same_is_still_found(rig):
    """What the trocar adds must not hide a reading that is frozen."""
    frozen = rig.true_robot.measured_js
    first = frozen()
    rig.true_robot.measured_js = lambda: replace(
        frozen(), position=first.position, velocity=np.zeros(10)
    )
    rig.until(lambda: rig.state is State.FAULTED, limit=5.0)
    assert rig.view.latch.reason is Reason.SENSOR_FAULT and "frozen" in rig.view.latch.words


def test_a_trocar_that_is_followed_is_not_set_by_hand():
    rig = FollowingRig()
    rig.context.current = type(rig.context.current)(rig.config, shared()[1])
    rig.run(0.3).awake()
    answer = TrocarRegistrar(rig.context, rig.executor).ask(rig.home, "/test").result(0)
    assert not answer.accepted and "followed from its tracker" in answer.message


class StillRobot:
    """A robot that remembers what it was sent, and was measured once."""

    def __init__(self, measured):
        self.measured, self.sent = measured, []

    def measured_js(self):
        return self.measured

    def servo_jp(self, setpoint):
        self.sent.append(setpoint)

    def hold(self):
        """There is nothing to hold."""


def test_a_stream_that_begins_anew_begins_where_the_robot_holds():
    """It ended while the shaft was catching up; nobody said `hold`."""
    config, model, context = shared()
    settings, pose = following_settings(), ActiveTrocarContext(context).trocar_pose
    robot = StillRobot(Rig().robot.measured_js())
    following = TrocarFollowing(robot, settings, model, lambda: State.MOVING, pose)
    q, now = robot.measured.position, 10.0
    for number in range(100):
        now += PERIOD
        following.take(Report(np.array(config.scene.trocar) + np.array([0.004, 0.0, 0.0]), now))
        if number < 30:
            following.servo_jp(Setpoint(q, np.zeros(10), now))
    assert 5e-4 < np.linalg.norm(following.shift) < 3.9e-3  # under way
    last = robot.sent[-1].position
    robot.measured = replace(robot.measured, stamp=now, velocity=np.zeros(10))
    assert np.abs(following.measured_js().velocity).max() == 0.0
    following.servo_jp(Setpoint(q, np.zeros(10), now + PERIOD))
    np.testing.assert_allclose(robot.sent[-1].position, last, atol=1e-12)


def test_jaws_that_tissue_keeps_open_are_not_frozen():
    config, model, usual = shared()
    context, rest = ActiveTrocarContext(usual), Rig().robot.measured_js()
    open_jaws = np.array(rest.position) + np.array([0.0] * 8 + [0.02, 0.02])
    robot = StillRobot(replace(rest, position=open_jaws))
    following = TrocarFollowing(
        robot, following_settings(), model, lambda: State.MOVING, context.trocar_pose
    )
    now = 10.0
    for share in np.linspace(0.0, 1.0, 400):
        now += PERIOD
        following.take(Report(np.array(config.scene.trocar), now))
        robot.measured = replace(robot.measured, stamp=now)
        closing = open_jaws - share * np.array([0.0] * 8 + [0.02, 0.02])
        assert "frozen" not in following.measured_js().fault
        following.servo_jp(Setpoint(closing, np.zeros(10), now))


class PlacedRig(FollowingRig):
    """A rig whose trocar is where the test puts it."""

    def __init__(self, off=0.0):
        super().__init__()
        self.off = off
        if off:  # the arm was guided into it by hand
            model, settle = shared()[1], self.context.current.with_trocar(self.trocar()).planner
            home = np.array(self.config.scene.home)
            at = Configuration(model, home).T_base_tip
            q = settle.solver.settle(home, at, settle.trocar).q
            self.true_robot = FakeRobot(robot_joints(q, 0.0), lambda: self.now)
            self.robot = self.followed()

    def trocar(self):
        return self.home + np.array([getattr(self, "off", 0.0), 0.0, 0.0])

    def carry(self, off, seconds=2.0):
        """Move the trocar there, slowly."""
        first = self.off
        for share in np.linspace(0.0, 1.0, 100):
            self.off = first + share * (off - first)
            self.run(seconds / 100)
        return self


@pytest.mark.parametrize("off", [0.002, 0.005])
def test_a_controller_that_starts_anew_finds_the_shaft_in_the_trocar_where_that_is(off):
    rig = PlacedRig()
    rig.run(0.3).awake().run(0.5).carry(off).run(0.5)
    before = rig.true_robot.measured_js().position
    rig.restart().run(1.0)
    assert rig.view.rcm_error < MOST
    rig.errors.clear()
    rig.awake().run(1.0)
    assert np.abs(rig.true_robot.measured_js().position - before).max() < 2e-3
    rig.finish("tense")
    assert max(rig.errors) < MOST
    rig.carry(0.0).run(0.5)
    assert max(rig.errors) < 3.0 * MOST  # it goes back in steps


def test_a_shaft_that_was_guided_into_a_trocar_that_has_moved_stays_in_it():
    rig = PlacedRig(off=0.003)
    rig.run(0.5)
    rig.errors.clear()
    rig.awake().run(2.0)
    assert max(rig.errors) < MOST
    assert rig.view.rcm_error < MOST


def test_a_shaft_in_the_patient_beside_the_trocar_is_not_led_further_off():
    rig = PlacedRig()
    rig.run(0.3).awake().run(0.5).carry(0.005).run(0.5)
    rig.restart().off = 0.0025  # it moved on while nobody followed
    rig.run(1.0)
    before = rig.true_robot.measured_js().position
    words = rig.refused("hey robot")
    assert "mm off the tracked trocar; nothing moves before that is within 1.00 mm" in words
    rig.run(1.0)
    np.testing.assert_allclose(rig.true_robot.measured_js().position, before, atol=1e-9)
    rig.carry(0.005).run(0.5)  # it breathes
    rig.carry(0.004).run(0.5).awake().carry(0.005).run(0.5)
    rig.errors.clear()
    rig.run(1.0)
    assert max(rig.errors) < MOST


@pytest.mark.parametrize("phase", ["open", "reach"])
def test_a_robot_that_held_by_itself_wakes_here_too(phase):
    rig = FollowingRig(0.0).run(0.3).moving(phase).run(0.1)
    rig.true_robot.hold()
    rig.true_robot.fault = "set-points stopped coming while moving, 21 ms ago"
    rig.until(lambda: not rig.executor.snapshot.is_moving)
    rig.run(0.5).say("hey robot")
    assert rig.run(0.5).state is State.ACTIVE
