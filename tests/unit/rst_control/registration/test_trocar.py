# SPDX-License-Identifier: BSD-3-Clause
"""Setting the trocar on a running controller: what is refused, and that all changes in one tick."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.registration.trocar import TrocarRegistrar
from rst_control.types import State
from tests.unit.rst_control.support.executor_rig import Rig, with_watchdogs
from tests.unit.rst_control.support.registration import Setting

TINY = 1e-9


class TrocarSetting(Setting):
    """A rig with somebody who sets its trocar."""

    refusal = ("trocar_refused", "set_trocar")

    def __init__(self, rig):
        super().__init__(rig, TrocarRegistrar)
        self.first = rig.context.current.trocar

    @property
    def point(self):
        return self.rig.context.current.trocar

    def place(self, aside=0.0, along=0.0):
        """A point [m] beside the shaft and along it, from where the trocar is on it."""
        joints = self.rig.robot.measured_js().position
        T = Configuration(self.rig.context.current.model, planning_joints(joints)[0]).T_base_shaft
        return self.first + aside * T[:3, 0] + along * T[:3, 2]


def setting(rig=None):
    return TrocarSetting(rig or Rig().awake())


@pytest.fixture
def here():
    return setting()


@pytest.mark.parametrize("make", [lambda: Rig().run(0.01), lambda: Rig().awake()])
def test_at_rest_a_trocar_on_the_shaft_is_accepted_with_its_distance(make):
    here = setting(make())
    message = here.accepted(here.place(aside=4e-4, along=0.02))
    assert "shaft 0.400 mm off it, allowed 1.000 mm" in message
    entry = here.rig.executor.events[-1]
    assert entry.kind == "trocar_set" and "was (0.406000, -0.024000, 0.415000) m" in entry.message
    assert here.rig.view.rcm_error == pytest.approx(4e-4, rel=1e-6)


def test_setting_moves_nothing(here):
    here.accepted(here.place(aside=9e-4))
    assert here.rig.still_for(0.5)
    assert here.rig.state is State.ACTIVE


def test_after_a_stop_the_trocar_may_be_set_and_the_latch_stays(here):
    here.rig.say("stop")
    here.accepted(here.place(aside=3e-4))
    assert here.rig.state is State.HALTED


def test_a_shaft_further_off_than_the_tolerance_is_refused_with_both_numbers(here):
    message = here.refused(here.place(aside=1.01e-3))
    assert "shaft 1.010 mm off it, allowed 1.000 mm" in message
    here.accepted(here.place(aside=0.99e-3))


def test_a_point_that_is_not_on_the_inserted_part_is_refused_with_the_depth(here):
    assert "17.8 mm of shaft inserted, allowed 50.0 to 250.0 mm" in here.refused(
        here.place(along=0.080366716231936 + TINY)
    )
    assert "allowed 50.0 to 250.0 mm" in here.refused(here.place(along=-0.16))


@pytest.mark.parametrize(
    "point", [(np.nan, 0.0, 0.4), (np.inf, 0.0, 0.4), (0.4, 3.0, 0.4), (0.4, -np.inf, 0.4)]
)
def test_points_that_are_not_finite_or_out_of_reach_are_refused(point):
    assert "m from base_link, allowed 0 to 1.601 m" in setting().refused(point)


@pytest.mark.parametrize("phase", ["reach", "pull"])
def test_while_moving_it_is_refused(phase):
    here = setting(Rig().moving(phase))
    assert here.refused(here.place()) == "moving; wait until the robot is at rest"


def test_while_braking_it_is_refused():
    here = setting(Rig().moving("reach"))
    here.rig.say("stop")
    assert here.rig.state is State.STOPPING
    assert here.refused(here.place()) == "stopping; wait until the robot is at rest"


def test_while_tissue_is_held_it_is_refused_and_after_release_it_is_not(here):
    here.rig.finish("tense")
    assert "tissue is held" in here.refused(here.place(aside=2e-4))
    here.rig.finish("release")
    here.accepted(here.place(aside=2e-4))


def test_a_joint_that_still_turns_is_named(here):
    measured = here.rig.robot.measured_js()
    velocity = np.zeros(10)
    velocity[4] = 0.02
    here.rig.robot.measured_js = lambda: replace(measured, velocity=velocity, stamp=here.rig.now)
    assert here.refused(here.place()) == "not at rest: joint_5 at 0.020 rad/s, allowed 0.010"


def test_without_joint_states_or_with_old_ones_it_is_refused():
    here = setting(Rig())
    measured = here.rig.robot.measured_js()
    place = here.place()
    here.rig.robot.measured_js = lambda: None
    assert here.refused(place) == "robot not connected"
    here.rig.robot.measured_js = lambda: replace(measured, stamp=here.rig.now - 0.1)
    assert "joint states stale, 100 ms old, allowed 20 ms" in here.refused(place)
    here.rig.robot.measured_js = lambda: replace(measured, stamp=here.rig.now, connected=False)
    assert here.refused(place) == "robot not connected"


def test_a_fault_of_the_robot_or_a_latch_by_a_watchdog_refuses_it():
    here = setting(Rig().run(0.01))
    here.rig.robot.fault = "joint_4 blocked"
    assert "robot fault: joint_4 blocked" in here.refused(here.place())
    here = setting()
    place, good = here.place(), here.rig.robot.measured_js
    here.rig.robot.measured_js = lambda: replace(good(), connected=False)
    here.rig.run(0.1)
    here.rig.robot.measured_js = good
    here.rig.tick()
    assert here.rig.state is State.FAULTED
    assert 'halted (robot not connected); say "hey robot" first' in here.refused(place)


def test_of_an_arm_that_was_guided_by_hand_it_is_set_after_hey_robot(here):
    place = here.place()
    here.rig.robot.fault = "arm_in_use: somebody else controls the arm"
    here.rig.run(0.01)
    words = 'somebody else controls the arm; let go of the arm, say "hey robot" first'
    assert words in here.refused(place)
    here.rig.say("hey robot")
    here.rig.run(0.1)
    here.accepted(place)


def test_a_refusal_by_the_shaft_is_judged_by_the_measured_joints_not_the_set_point():
    here = setting(Rig(config=with_watchdogs(following_error=0.5)).believing().awake())
    place = here.place()
    here.rig.robot.push(np.array([0.0] * 3 + [0.01] + [0.0] * 6))
    here.rig.robot.servo_jp = lambda setpoint: None
    here.rig.tick()
    assert "off it, allowed" in here.refused(place)


def test_a_command_verified_before_is_verified_again_by_the_new_trocar(here):
    queue, new = here.rig.queue, here.place(aside=5e-4)
    pending = here.rig.verified()  # by the old trocar
    here.accepted(new)  # takes effect before the order is taken up, in the same tick
    assert not pending.reply.done()
    assert here.rig.state is State.ACTIVE
    queue.check(queue.next(0.0))
    here.rig.tick()
    assert pending.reply.result(0).accepted
    assert here.rig.state is State.MOVING
    here.rig.until(pending.ended.done)
    assert here.rig.rcm(here.rig.joints) < 1e-6
    assert here.rig.context.current.shaft(here.rig.joints).error < 1e-6


def test_a_command_verified_before_is_refused_where_the_new_trocar_forbids_it(here):
    pending = here.rig.verified()
    here.accepted(here.place(along=-0.145))  # so much shaft inside that the grasp is too deep
    here.rig.queue.check(here.rig.queue.next(0.0))
    here.rig.tick()
    assert not pending.reply.result(0).accepted
    assert "shaft inserted, allowed 50.0 to 250.0 mm" in pending.reply.result(0).message
    assert here.rig.still_for(0.5)


def test_a_refusal_leaves_a_verified_command_as_it_is(here):
    pending = here.rig.verified()
    assert not here.ask(here.place(aside=5e-3)).accepted
    assert pending.reply.result(0).accepted


def test_a_change_in_the_middle_of_a_verification_makes_it_worthless(here):
    queue, verify, new = here.rig.queue, here.rig.context.verify, here.place(aside=5e-4)

    def verify_slowly(request, situation):
        decision = verify(request, situation)
        here.accepted(new)
        return decision

    queue._verify = verify_slowly
    pending = here.rig.verified()
    here.rig.tick()
    assert not pending.reply.done()
    assert here.rig.state is State.ACTIVE


def test_measurement_and_verification_change_in_the_same_tick(here):
    new = here.place(aside=5e-4)
    answer = here.registrar.ask(new, "/test")
    assert here.rig.rcm(here.rig.joints) < 1e-9  # nothing has changed before the tick
    assert not answer.done()
    serial = here.rig.view.serial
    here.rig.tick()
    assert answer.result(0).accepted
    assert here.rig.view.serial > serial
    assert here.rig.view.rcm_error == pytest.approx(5e-4, rel=1e-6)


def test_the_next_motion_first_puts_the_shaft_into_the_new_trocar_without_a_watchdog(here):
    here.accepted(here.place(aside=9.9e-4))
    first = len(here.rig.sent)
    here.rig.finish("tense")
    errors = [here.rig.rcm(s.position) for s in here.rig.sent[first:]]
    assert max(errors) < 1e-3
    seated = next(n for n, error in enumerate(errors) if error < 1e-6)
    assert max(errors[seated:]) < 1e-6


def test_a_question_that_was_withdrawn_changes_nothing(here):
    before = here.rig.context.current
    answer = here.registrar.ask(here.place(aside=5e-4), "/test")
    assert answer.cancel()
    here.rig.run(0.01)
    assert here.rig.context.current is before
    assert "trocar_set" not in here.rig.event_kinds()


def test_two_who_ask_at_once_are_both_answered_and_the_last_one_counts(here):
    points = [here.place(aside=1e-4 * n) for n in range(8)]
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda point: here.registrar.ask(point, "/test"), points))
    here.rig.run(0.02)
    assert all(answer.result(0).accepted for answer in answers)
    assert any(np.allclose(here.rig.context.current.trocar, point, atol=1e-12) for point in points)
    assert here.rig.event_kinds().count("trocar_set") == 8
