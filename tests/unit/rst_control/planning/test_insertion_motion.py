# SPDX-License-Identifier: BSD-3-Clause
"""Insertion and withdrawal in the running executor, without physics."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from bench.kinova.rig import kinova_motion
from rst_control.kinova.config import bridge_limits, load_kinova_config
from rst_control.registration.trocar_context import TrocarContext
from rst_control.robot.setpoint_servo import Servo
from rst_control.types import State
from tests.support.changed_settings import changed
from tests.unit.rst_control.support.executor_rig import Rig, shared, with_watchdogs

ROUNDING = 1e-9


@pytest.fixture(scope="module")
def quick():
    """Makes rigs that go through the trocar faster than is shipped, to keep the tests short."""
    config, model, _ = shared()
    config = changed(config, speed={"insertion": 0.05, "approach": 0.1})
    return partial(Rig, config=config, context=TrocarContext(config, model))


@pytest.fixture
def away(gate):
    return gate + 0.4 * np.eye(9)[0]


def during(rig, phase, words):
    """A rig that is well into a phase of a command."""
    rig.awake().say(words)

    def is_well_into_it():
        view = rig.view
        return rig.phase == phase and view.path is not None and view.motion.progress > 0.3

    return rig.until(is_well_into_it, limit=90.0)


def test_from_outside_the_tool_goes_in_works_and_comes_out_again(away, quick):
    rig = quick(start=away).awake()
    assert rig.view.insertion < -0.03
    seen = {"insert": set(), "withdraw": set()}
    for words in ("insert", "tense", "release", "withdraw"):
        if words == "withdraw":
            rig.robot.tissue = None  # that of the rig is wherever the jaws close
        pending = rig.say(words)
        while not pending.ended.done():
            rig.tick()
            place = rig.view.trocar_pose
            assert place.is_outside or place.error < 1e-6
            seen.get(words, set()).add(rig.phase)
        assert pending.ended.result(0).kind == "succeeded", pending.ended.result(0)
        assert pending.ended.result(0).max_rcm_error < 1e-6
    assert seen["insert"] >= {"approach", "align", "insert"}
    assert seen["withdraw"] >= {"align", "withdraw"}
    assert rig.view.insertion == pytest.approx(-rig.config.scene.standoff, abs=1e-6)
    assert rig.state is State.ACTIVE


@pytest.mark.parametrize("words", ["insert", "withdraw"])
def test_neither_is_taken_from_the_voice_node_heartbeat_or_not(away, words):
    rig = Rig(start=away).awake()
    rig.executor.heartbeat(rig.now)
    for is_spoken in (True, False):
        pending = rig.queue.take(words, "/voice", is_spoken, is_by_hand=False)
        reply = pending.reply.result(0)
        assert not reply.accepted and "by hand, never by voice" in reply.message
    assert "never by voice" in rig.queue.take(words, "x", True).reply.result(0).message
    assert rig.queue.next(0.0) is None
    assert rig.still_for(0.1)


@pytest.mark.parametrize(
    ("phase", "words"),
    [("approach", "insert"), ("insert", "insert"), ("align", "withdraw"), ("withdraw", "withdraw")],
)
def test_a_stop_in_any_phase_brakes_along_the_path_latches_and_lets_it_go_on(
    away, quick, phase, words
):
    rig = during(quick(start=away if words == "insert" else None), phase, words)
    path, first = rig.view.path, len(rig.sent)
    rig.say("stop")
    rig.rest()
    assert rig.state is State.HALTED
    assert rig.view.path is path
    speeds = [np.abs(s.velocity).max() for s in rig.sent[first:]]
    assert (len(speeds) - 1) * 0.002 < 0.1 and speeds[-1] == 0.0
    np.testing.assert_allclose(
        rig.joints[:8], path.evaluate(rig.view.path_position).q[:8], atol=ROUNDING
    )
    if phase != "approach":
        assert max(rig.rcm(s.position) for s in rig.sent[first:]) < 1e-6
    assert rig.still_for(0.2)
    assert "halted" in rig.refused(words)
    rig.say("hey robot")
    rig.finish(words)


def test_part_way_in_it_may_turn_back(away, quick):
    rig = during(quick(start=away), "insert", "insert")
    rig.say("stop")
    rig.rest()
    assert not rig.view.trocar_pose.is_outside
    rig.say("hey robot")
    assert "of shaft inserted, allowed 50.0" in rig.refused("tense")
    rig.finish("withdraw")
    assert rig.view.trocar_pose.is_outside


def stuck_at(newtons, rig):
    """A tension sensor that says so whatever pulls."""
    measured_js = rig.robot.measured_js
    rig.robot.measured_js = lambda: replace(
        measured_js(), force=-newtons * np.array(rig.config.scene.pull_direction)
    )


def test_a_tension_sensor_that_is_stuck_does_not_keep_the_tool_in_the_patient(quick):
    rig = quick().awake()
    rig.robot.tissue = None
    stuck_at(3.0, rig)
    rig.run(0.5)
    rig.finish("withdraw")
    assert rig.view.trocar_pose.is_outside


def test_nor_does_it_keep_the_jaws_at_tissue_that_they_have_released(quick):
    rig = quick().awake()
    rig.finish("tense", tension=0.5)
    stuck_at(3.0, rig)
    rig.finish("release")
    assert not rig.view.measurement.gripped


def test_jaws_that_catch_tissue_end_the_withdrawal_before_it_begins():
    rig = Rig().awake()
    rig.finish("tense")
    rig.finish("release")  # leaves the jaws open; the rig's tissue is wherever they close
    pending = rig.say("withdraw")
    joints = rig.joints
    rig.until(pending.ended.done)
    assert pending.ended.result(0).kind == "failed"
    assert "caught tissue" in pending.ended.result(0).message
    np.testing.assert_array_equal(joints[:8], rig.joints[:8])
    assert "release first" in rig.refused("withdraw")


# The watch over the trocar.


def test_a_tool_pushed_below_the_surface_beside_the_trocar_brakes(away):
    rig = Rig(start=away, config=with_watchdogs(following_error=1.0)).believing()
    during(rig, "approach", "insert")
    lowest = rig.view.trocar_pose.height
    below = rig.joints.copy()
    while rig.context.trocar_pose(below).is_outside:
        below[1] += 0.01
    assert lowest > 0.0 and rig.context.trocar_pose(below).error > 1e-3
    rig.robot.push(below - rig.robot.measured_js().position)
    rig.robot.servo_jp = lambda setpoint: None
    rig.rest()
    assert rig.state is State.FAULTED
    assert "off the trocar" in rig.view.mode.reason
    assert "above the patient's surface" in rig.view.mode.reason


def test_a_shaft_pushed_aside_part_way_in_brakes(away, quick):
    rig = during(quick(start=away).believing(), "insert", "insert")
    rig.until(lambda: rig.view.insertion > 0.0)
    rig.robot.push(np.eye(10)[3] * 0.005)
    rig.robot.servo_jp = lambda setpoint: None
    rig.rest()
    assert rig.state is State.FAULTED
    assert "off the trocar, allowed 1.00 mm" in rig.view.mode.reason


def test_the_watch_sees_every_new_measurement_of_every_tick_of_a_motion(away):
    rig = Rig(start=away).awake()
    measured, judged = [], []
    locate, watch = rig.executor._robot.trocar_pose_of, rig.executor._watchdogs.motion

    def located(joints):
        measured.append(locate(joints))
        return measured[-1]

    def watched(now, measurement, seen):
        judged.append(seen.trocar_pose)
        return watch(now, measurement, seen)

    rig.executor._robot.trocar_pose_of, rig.executor._watchdogs.motion = located, watched
    rig.finish("insert")
    assert len(judged) > 5000
    assert all(one is other for one, other in zip(judged, measured, strict=False))


@pytest.mark.parametrize("broken", [float("nan"), float("inf")])
def test_a_shaft_whose_place_is_not_known_brakes(away, broken):
    rig = during(Rig(start=away), "approach", "insert")
    place = replace(rig.view.trocar_pose, error=broken, is_outside=False)
    rig.executor._robot.trocar_pose_of = lambda joints: place
    rig.rest()
    assert rig.state is State.FAULTED
    assert "off the trocar" in rig.view.mode.reason


@pytest.mark.parametrize("turn", [1.0, -1.5])  # [rad] of joint_7, which is the slowest to turn back
def test_the_servo_of_the_real_arm_takes_a_plan_at_a_joints_speed_limit(gate, turn):
    motion = kinova_motion({"controller": {"speed": {"scale": 1.0}}})
    start = gate + turn * np.eye(9)[6]
    rig = Rig(start=start, config=motion, context=TrocarContext(motion, shared()[1])).awake()
    rig.finish("insert")
    kinova = replace(load_kinova_config(), limits=motion.limits, scene=motion.scene)
    limits = bridge_limits(kinova)
    sent = [setpoint for setpoint in rig.sent if setpoint is not None]
    servo = Servo(kinova.bridge.servo, limits, sent[0].position)
    for setpoint in sent:
        servo.accept(setpoint, setpoint.stamp)
        servo.course(setpoint.stamp)
        assert servo.fault == ""
    fastest = max(np.abs(setpoint.velocity[6]) for setpoint in sent)
    assert fastest == pytest.approx(limits.speed[6], rel=1e-5)
