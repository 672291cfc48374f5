# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rst_control.commands.camera_step import STEPS
from rst_control.commands.table import COMMANDS
from rst_control.types import State
from tests.unit.rst_control.support.executor_rig import PERIOD, Rig

SITUATIONS = {
    "standby": lambda: Rig().run(0.01),
    "active": lambda: Rig().awake(),
    "holding": lambda: holding(),
    "reaching": lambda: Rig().moving("reach"),
    "pulling": lambda: Rig().moving("pull"),
    "releasing": lambda: releasing(),
    "braking": lambda: braking("stop"),
    "standing by soon": lambda: braking("terminate"),
    "halted": lambda: braking("stop").rest(),
    "faulted": lambda: faulted(),
}
ALWAYS = {"hey robot", "stop"}
PULLS = {"pull more", "pull less"}
ALLOWED = {
    "standby": ALWAYS,
    "active": ALWAYS | {"tense", "withdraw", "terminate", *STEPS},
    "holding": ALWAYS | PULLS | {"release", "terminate"},
    "reaching": ALWAYS | {"terminate"},
    "pulling": ALWAYS | PULLS | {"terminate"},
    "releasing": ALWAYS | {"terminate"},
    "braking": {"stop", "terminate"},
    "standing by soon": {"stop", "terminate"},
    "halted": ALWAYS | {"terminate"},
    "faulted": ALWAYS | {"terminate"},
}


def holding():
    rig = Rig().awake()
    rig.finish("tense")
    return rig


def releasing():
    rig = holding()
    rig.say("release")
    return rig.run(0.02)


def braking(words):
    rig = Rig().moving("reach")
    rig.say(words)
    assert rig.state is State.STOPPING
    return rig


def faulted():
    rig = Rig().moving("reach")
    rig.robot.fault = "broken"
    rig.robot.hold()
    rig.run(0.2)
    assert rig.state is State.FAULTED
    return rig


@pytest.mark.parametrize("situation", SITUATIONS)
def test_every_command_in_every_state_is_accepted_or_refused_as_the_table_says(situation):
    rig, phrases = SITUATIONS[situation](), {c.phrase for c in COMMANDS.values()}
    begin = rig.state, rig.phase

    def still_there():
        """The rig, or a new one where this is no longer in the situation: braking is over soon."""
        return rig if (rig.state, rig.phase) == begin else SITUATIONS[situation]()

    for phrase in sorted(phrases - ALLOWED[situation]):
        rig = still_there()
        refusals = rig.event_kinds().count("refused")
        words = rig.refused(phrase)
        assert rig.view.last_refusal.words == words
        assert rig.event_kinds().count("refused") == refusals + 1
    for phrase in sorted(ALLOWED[situation]):
        rig = still_there()
        rig.say(phrase)


def test_the_seven_commands_do_what_the_table_of_meanings_says():
    rig = holding()
    initial = rig.config.controller.tension.initial
    assert rig.view.tension == pytest.approx(initial, abs=0.03)
    assert rig.view.tension_target == initial
    more = rig.finish("pull more").tension
    assert more > initial
    assert rig.finish("pull less").tension < more
    assert rig.finish("release").tension == 0.0
    assert not rig.view.is_tissue_held and rig.view.grasp is None
    rig.say("terminate")
    assert rig.state is State.STANDBY and not rig.view.mode.is_active


def test_the_measured_joints_are_the_first_set_point():
    rig = Rig()
    start = rig.robot.measured_js().position
    for setpoint in (rig.tick() for _ in range(5)):
        np.testing.assert_array_equal(setpoint.position, start)
        assert not setpoint.velocity.any()


def test_where_the_robot_holds_is_the_first_set_point_though_the_load_bends_its_joints():
    rig = Rig()
    rig.robot.push(np.full(10, 1e-4))
    rig.robot.sent_to = rig.robot.measured_js().position - 1e-4
    np.testing.assert_array_equal(rig.tick().position, rig.robot.sent_to)


def test_joints_that_are_not_where_the_robot_holds_them_are_taken_where_they_are():
    rig = Rig()
    measured = rig.robot.measured_js().position
    rig.robot.sent_to = measured + np.eye(10)[3] * 0.2
    np.testing.assert_array_equal(rig.tick().position, measured)


def test_nothing_is_sent_before_the_robot_is_there():
    rig = Rig()
    rig.robot.is_connected = False
    assert rig.run(0.1).sent == [None] * 50
    assert rig.refused("hey robot") == "robot not connected"


def test_no_motion_while_the_robot_is_not_there():
    rig = Rig().awake()
    rig.robot.is_connected = False
    rig.run(0.01)
    assert rig.state is State.FAULTED
    assert "not connected" in rig.refused("tense")


def test_a_robot_that_comes_back_elsewhere_is_taken_where_it_is():
    rig = Rig().awake()
    rig.robot.is_connected = False
    rig.run(0.01)
    rig.robot.push(np.full(10, 0.3))
    elsewhere = rig.robot.measured_js().position
    rig.robot.is_connected = True
    rig.run(0.01)
    assert rig.state is State.FAULTED
    np.testing.assert_array_equal(rig.robot.measured_js().position, elsewhere)
    rig.say("hey robot")
    assert rig.still_for(0.1)
    np.testing.assert_array_equal(rig.robot.measured_js().position, elsewhere)


def test_an_arm_that_was_pushed_away_is_not_pulled_back_by_hey_robot():
    rig = Rig().awake()
    servo, rig.robot.servo_jp = rig.robot.servo_jp, lambda setpoint: None
    rig.robot.push(np.full(10, 0.06))
    rig.run(0.01)
    assert rig.state is State.FAULTED
    elsewhere = rig.robot.measured_js().position
    rig.say("hey robot")
    rig.robot.servo_jp = servo
    rig.run(0.1)
    np.testing.assert_array_equal(rig.robot.measured_js().position, elsewhere)


def test_the_outcome_reports_the_largest_rcm_error_measured_in_motion():
    rig = Rig().awake()
    rig.robot.push(np.full(10, 1e-3))  # before the motion: does not count
    rig.run(0.01)
    pending = rig.say("tense")
    rig.until(lambda: rig.phase == "reach")
    rig.robot.push(np.full(10, 1e-4))
    pushed = rig.rcm(rig.robot.measured_js().position)
    rig.until(pending.ended.done)
    assert pushed > 1e-6
    assert pending.ended.result(0).max_rcm_error == pytest.approx(pushed)


def test_a_grasp_is_remembered_until_the_jaws_have_let_go():
    rig = holding()
    rig.say("release")
    rig.say("stop")
    rig.rest()
    assert rig.view.grasp is not None
    rig.say("hey robot")
    rig.finish("release")
    rig.tick()
    assert rig.executor._setpoint_state.grasp is None


def test_a_pull_that_was_stopped_has_no_target_any_more():
    rig = Rig().moving("pull")
    rig.say("stop")
    rig.rest()
    assert rig.view.tension_target == 0.0
    assert rig.view.grasp.s == pytest.approx(rig.view.path_position)


def test_set_points_are_continuous_over_a_whole_session():
    rig = holding()
    for words in ("pull more", "pull less", "release", "tense"):
        rig.finish(words)
    joints = np.array([s.position for s in rig.sent])
    velocity = np.array([s.velocity for s in rig.sent])
    jump = np.abs(np.diff(joints, axis=0) - 0.5 * PERIOD * (velocity[1:] + velocity[:-1]))
    assert jump.max() < 2e-5


def test_pull_more_takes_over_from_a_pull_at_its_speed():
    rig = Rig().moving("pull")
    first = rig.executor.snapshot.motion.path_speed
    pending = rig.say("pull more")
    after = rig.executor.snapshot.motion.path_speed
    assert abs(after - first) < 3 * PERIOD * rig.config.controller.speed.acceleration
    assert rig.view.tension_target == pytest.approx(
        rig.config.controller.tension.initial + rig.config.controller.tension.step_tension
    )
    rig.until(pending.ended.done)
    assert rig.view.tension == pytest.approx(rig.view.tension_target, abs=0.03)


def test_a_motion_that_is_replaced_ends_as_stopped_with_the_reason():
    rig = Rig().awake()
    tense = rig.say("tense")
    rig.until(lambda: rig.phase == "pull")
    rig.say("pull more")
    assert tense.ended.result(0).kind == "stopped"
    assert "pull more" in tense.ended.result(0).message


def test_pull_more_said_twice_at_once_counts_twice():
    rig = holding()
    start = rig.view.tension_target
    rig.say("pull more")
    rig.say("pull more")
    rig.rest(20.0)
    step = rig.config.controller.tension.step_tension
    assert rig.view.tension == pytest.approx(start + 2 * step, abs=0.03)


def test_jaws_that_close_on_nothing_end_the_motion_without_a_latch():
    rig = Rig().awake()
    rig.robot.tissue = None
    pending = rig.say("tense")
    rig.until(pending.ended.done)
    assert pending.ended.result(0).kind == "failed"
    assert "nothing grasped" in pending.ended.result(0).message
    assert rig.state is State.ACTIVE
    assert rig.still_for(0.1)


def test_before_the_robot_spoke_a_tick_sends_nothing_and_has_its_time():
    executor = Rig().executor
    assert executor.tick(5.0, None) is None
    assert executor.snapshot.stamp == 5.0


@given(tick=st.integers(0, 2400), how=st.sampled_from(["stop", "terminate"]))
@settings(max_examples=40)
def test_a_stop_at_any_moment_brakes_at_once_stays_on_the_trocar_and_holds(tick, how):
    rig = Rig().awake()
    rig.say("tense")
    rig.run(tick * PERIOD)
    if rig.state is not State.MOVING:
        return
    before, opening = rig.sent[-1].velocity, rig.joints[8:].sum()
    phase, first = rig.phase, len(rig.sent)
    rig.say(how)
    assert (np.abs(rig.sent[first].velocity) <= np.abs(before) + 1e-4).all()
    moved = np.abs(before).max() > 1e-3
    assert not moved or np.linalg.norm(rig.sent[first].velocity) < np.linalg.norm(before)
    rig.rest(1.0)
    assert max(rig.rcm(s.position) for s in rig.sent[first:]) < 1e-6
    assert phase in ("open", "close") or rig.joints[8:].sum() == pytest.approx(opening)
    assert rig.state is (State.HALTED if how == "stop" else State.STANDBY)
    for words in ("tense", "release", "pull more", "pull less"):
        rig.refused(words)
    assert rig.still_for(0.1)
    rig.say("hey robot")
    assert rig.still_for(0.1)


def test_tissue_stays_held_through_stop_and_terminate_and_can_then_be_released():
    for how in ("stop", "terminate"):
        rig = Rig().moving("pull")
        rig.say(how)
        rig.rest()
        assert rig.view.is_tissue_held and rig.view.tension > 0.1
        rig.say("hey robot")
        rig.finish("pull more")
        rig.finish("release")
        assert rig.view.tension == 0.0


def test_every_step_of_a_stop_in_motion_is_in_the_event_log():
    rig = Rig().moving("reach")
    rig.say("stop")
    rig.rest()
    rig.say("hey robot")
    assert rig.event_kinds()[-5:] == ["stop_received", "at_rest", "halted", "accepted", "cleared"]


def test_hey_robot_is_refused_while_the_robot_is_measured_moving():
    rig = braking("stop").rest()
    rig.robot._velocity = np.full(10, 0.1)
    rig.robot.servo_jp = lambda _: None
    assert "rest" in rig.refused("hey robot")
    assert rig.state is State.HALTED


def test_a_late_tick_catches_up_with_time_but_never_by_much():
    rig = Rig().moving("reach")
    step = np.linalg.norm(rig.sent[-1].position - rig.sent[-2].position)
    rig.now += 2 * PERIOD
    rig.tick()
    assert np.linalg.norm(rig.sent[-1].position - rig.sent[-2].position) == pytest.approx(
        3 * step, rel=0.05
    )
    rig.now += 1.0
    rig.tick()
    assert np.linalg.norm(rig.sent[-1].position - rig.sent[-2].position) < 6 * step


def test_an_amount_is_shown_with_its_command_and_one_that_is_not_given_is_not():
    rig = holding()
    assert rig.view.command == "tense"
    rig.finish("Pull  LESS 0.1N")
    assert rig.view.command == "pull less 0.1 N"
    rig.finish("pull more", distance=5e-4)
    assert rig.view.command == "pull more 0.5 mm"
    said = [e.command for e in rig.executor.events if e.kind == "motion_started"]
    assert said[-2:] == ["pull less 0.1 N", "pull more 0.5 mm"]
    rig.refused("release 1 mm")
    assert rig.view.command == "pull more 0.5 mm"
    rig.finish("release")
    assert rig.view.command == "release"
