# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.planning.patient_surface import NOWHERE, TrocarPose
from rst_control.supervision.node_liveness import NodeLiveness
from rst_control.supervision.plausibility import SensorWatch, max_joint_speed
from rst_control.supervision.watchdogs import MonitoredMotion, WatchdogLimits, Watchdogs
from rst_control.types import Cause, Measurement, Reason, State
from tests.unit.rst_control.support.executor_rig import Rig, shared, with_watchdogs

SETTINGS = shared()[0].controller
WATCHDOGS = Watchdogs(
    WatchdogLimits(SETTINGS.watchdogs, rcm_error=1e-3, tension=2.4),
    SensorWatch(SETTINGS, max_joint_speed(shared()[0].limits)),
    NodeLiveness(),
)
INSIDE = TrocarPose(error=1e-6, insertion=0.12, wrist=0.09, height=-0.13, is_outside=False)
FAR = TrocarPose(error=0.2, insertion=-0.3, wrist=-0.3, height=0.3, is_outside=True)
GOOD = MonitoredMotion(
    setpoint=np.zeros(10),
    trocar_pose=INSIDE,
    raises_tension=True,
    needs_grip=False,
    overtime=0.1,
    heartbeat_age=None,
)


def measured(**changes):
    zeros = np.zeros(10)
    return replace(Measurement(position=zeros, velocity=zeros, effort=zeros, stamp=0.0), **changes)


def test_nothing_is_wrong_with_a_robot_where_it_was_sent():
    assert WATCHDOGS.motion(0.001, measured(), GOOD) is None
    assert WATCHDOGS.motion(0.019, measured(), GOOD) is None


def off(**changes):
    return replace(GOOD, trocar_pose=replace(INSIDE, **changes))


@pytest.mark.parametrize(
    ("now", "measurement", "watched", "words"),
    [
        (0.0, None, GOOD, "not connected"),
        (0.0, measured(connected=False), GOOD, "not connected"),
        (0.021, measured(), GOOD, "stale, 21 ms old, allowed 20 ms"),
        (0.021, measured(fault="3 refused"), GOOD, "allowed 20 ms: 3 refused"),
        (0.0, measured(fault="brakes on"), GOOD, "brakes on"),
        (0.0, measured(position=np.eye(10)[3] * 0.06), GOOD, "joint_4 0.060 rad off"),
        (0.0, measured(), replace(GOOD, setpoint=np.full(10, np.nan)), "off its set-point"),
        (0.0, measured(), off(error=1.1e-3), "1.10 mm off the trocar"),
        (0.0, measured(), off(error=float("nan")), "off the trocar"),
        (0.0, measured(), off(error=0.05, height=0.002), "2.0 mm above the pat"),
        (0.0, measured(), replace(GOOD, trocar_pose=NOWHERE), "off the trocar"),
        (0.0, measured(force=np.array([0.0, 0.0, -2.5])), GOOD, "tension 2.50 N, allowed 2.40 N"),
        (0.0, measured(), replace(GOOD, needs_grip=True), "slipped"),
        (0.0, measured(), replace(GOOD, heartbeat_age=0.6), "voice node silent"),
        (0.0, measured(), replace(GOOD, overtime=61.0), "61.0 s longer than planned, allowed 60 s"),
    ],
)
def test_each_fault_is_named_with_what_was_allowed(now, measurement, watched, words):
    assert words in WATCHDOGS.motion(now, measurement, watched).words


def test_the_shaft_may_be_anywhere_only_while_the_whole_robot_is_outside():
    assert WATCHDOGS.motion(0.0, measured(), replace(GOOD, trocar_pose=FAR)) is None
    near = replace(FAR, is_outside=False)
    found = WATCHDOGS.motion(0.0, measured(), replace(GOOD, trocar_pose=near))
    assert "off the trocar" in found.words


def test_the_shaft_may_be_off_the_trocar_while_only_the_jaws_open():
    adrift = off(error=2e-3)
    assert WATCHDOGS.motion(0.0, measured(), replace(adrift, only_opens=True)) is None
    assert WATCHDOGS.motion(0.0, measured(), adrift).reason is Reason.OFF_TROCAR
    faulty = WATCHDOGS.motion(0.0, measured(fault="x"), replace(adrift, only_opens=True))
    assert faulty.reason is Reason.FAULTED


def test_tension_over_its_limit_does_not_keep_the_robot_from_easing_it():
    high = measured(force=np.array([0.0, 0.0, 3.0]))
    assert WATCHDOGS.motion(0.0, high, replace(GOOD, raises_tension=False)) is None


STUCK = {"tension_invalid_reason": "tension 3.00 N with nothing held, allowed 0.10 N"}


def pulled(newtons, **changes):
    return measured(force=np.array([0.0, 0.0, -newtons]), **changes)


def leaving(measurement, since):
    return WATCHDOGS.motion(0.0, measurement, replace(GOOD, easing_since=since))


def test_a_sensor_that_is_stuck_high_does_not_keep_empty_jaws_in_the_patient():
    assert leaving(pulled(3.0, **STUCK), since=1.0) is None
    assert leaving(pulled(5.39, **STUCK), since=1.0) is None
    assert leaving(pulled(5.41, **STUCK), since=1.0).reason is Reason.OVER_TENSION  # it is caught
    assert leaving(pulled(5.41, **STUCK), since=2.0) is None


@pytest.mark.parametrize(
    ("since", "changes"), [(3.0, {}), (4.0, {**STUCK, "gripped": True}), (None, STUCK)]
)
def test_one_that_is_trusted_or_tissue_that_is_held_or_a_motion_that_loads_brakes(since, changes):
    assert leaving(pulled(3.0, **changes), since).reason is Reason.OVER_TENSION


def test_tissue_that_sticks_to_the_jaws_as_they_leave_brakes():
    assert leaving(pulled(0.0), since=5.0) is None
    assert leaving(pulled(2.5, **STUCK), since=5.0).reason is Reason.OVER_TENSION


def test_a_robot_fault_is_distinguished_from_a_lost_robot():
    assert WATCHDOGS.robot(0.0, measured(fault="x")).reason is Reason.FAULTED
    assert WATCHDOGS.robot(0.0, None).reason is Reason.NOT_CONNECTED
    assert WATCHDOGS.robot(1.0, measured()).reason is Reason.STALE


# In the running executor: every fault brakes along the path, latches, and needs "hey robot".


def raise_error(joints):
    raise ArithmeticError("not a number")


def _freeze(rig):
    rig.robot.freeze()


def _drift(rig):
    """The jaws open at 1 rad/s each, and say so."""
    measured_js, start, jaws = rig.robot.measured_js, rig.now, np.repeat([0.0, 1.0], [8, 2])

    def drifting():
        true = measured_js()
        position = true.position + jaws * (true.stamp - start)
        return replace(true, position=position, velocity=true.velocity + jaws)

    rig.robot.measured_js = drifting


def _disconnect(rig):
    rig.robot.is_connected = False


def _fault(rig):
    rig.robot.fault = "brakes on"


def _stiffen(rig):
    rig.robot.tissue.stiffness = 20_000.0


def _slip(rig):
    rig.robot.tissue = None


def _crash(rig):
    rig.executor._robot.trocar_pose_of = raise_error


FAULTS = {
    _freeze: (Reason.STALE, "stale"),
    _drift: (Reason.OFF_SETPOINT, "off its set-point"),
    _disconnect: (Reason.NOT_CONNECTED, "not connected"),
    _fault: (Reason.FAULTED, "brakes on"),
    _stiffen: (Reason.SENSOR_FAULT, "tension jumped"),
    _slip: (Reason.SLIPPED, "slipped"),
}


def fault_in_motion(rig, fault):
    """Bring the fault about while the robot pulls; returns set-points from then on."""
    fault(rig)
    first = len(rig.sent)
    rig.until(lambda: rig.state is not State.MOVING, limit=0.1)
    rig.until(lambda: rig.state is State.FAULTED, limit=0.5)
    return [s for s in rig.sent[first:] if s is not None]


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_brakes_along_the_path_and_latches_with_its_name(fault):
    rig = Rig().moving("pull")
    sent = fault_in_motion(rig, fault)
    reason, words = FAULTS[fault]
    assert words in rig.view.mode.reason and rig.view.mode.cause.reason is reason
    assert {e.reason for e in rig.executor.events if e.kind == "halted"} == {reason}
    assert max(rig.rcm(s.position) for s in sent) < 1e-6
    speed = [np.linalg.norm(s.velocity) for s in sent]
    assert speed[-1] < 1e-9
    assert rig.event_kinds()[-2:] == ["at_rest", "halted"]
    assert "halted" in rig.refused("pull more")


def test_joint_states_that_come_back_move_nothing_until_hey_robot():
    rig = Rig().moving("pull")
    fault_in_motion(rig, _freeze)
    rig.robot.thaw()
    assert rig.still_for(0.5)
    rig.say("hey robot")
    assert rig.still_for(0.2)
    assert rig.state is State.ACTIVE


def test_hey_robot_clears_the_fault_of_the_robot_and_waits_until_it_is_clear():
    rig = Rig().moving("reach")
    fault_in_motion(rig, _fault)
    rig.robot.hold()
    rig.say("hey robot")
    assert rig.robot.clear_count == 1
    assert rig.state is State.ACTIVE


def test_hey_robot_is_refused_where_the_robot_cannot_clear_its_fault():
    rig = Rig().moving("reach")
    fault_in_motion(rig, _fault)
    rig.robot.clears_fault = False
    assert "brakes on" in rig.refused("hey robot")
    assert rig.state is State.FAULTED


def test_an_error_in_the_loop_brakes_and_a_second_one_leaves_holding_to_the_robot():
    rig = Rig().moving("reach")
    locate = rig.executor._robot.trocar_pose_of
    _crash(rig)
    with pytest.raises(ArithmeticError):
        rig.tick()
    rig.executor.crashed(ArithmeticError("not a number"))
    rig.executor._robot.trocar_pose_of = locate
    rig.tick()
    assert rig.state is State.STOPPING and "not a number" in rig.view.mode.reason
    assert rig.view.mode.cause.reason is Reason.LOOP_ERROR
    rig.executor.crashed(ArithmeticError("again"))
    assert rig.executor._setpoint_state.motion is None
    rig.robot.hold()
    rig.rest()
    assert rig.state is State.FAULTED
    assert rig.still_for(0.1)


def test_a_spoken_command_brakes_when_the_voice_node_falls_silent():
    rig = Rig().awake()
    rig.executor.heartbeat(rig.now)
    rig.say("tense", spoken=True)
    for _ in range(8):
        rig.run(0.1)
        rig.executor.heartbeat(rig.now)
    assert rig.state is State.MOVING
    rig.until(lambda: rig.state is State.FAULTED, limit=1.0)
    assert "voice node silent" in rig.view.mode.reason
    assert rig.view.mode.cause.reason is Reason.VOICE_SILENT


def test_a_robot_that_held_by_itself_wakes_though_set_points_went_on_while_it_stood():
    rig = Rig().moving("close")
    rig.run(0.1)
    rig.robot.hold()
    rig.robot.fault = "set-points stopped coming while moving, 21 ms ago"
    rig.until(lambda: not rig.executor.snapshot.is_moving)
    rig.run(0.5)
    assert rig.executor.snapshot.mode.reason.startswith("robot fault: set-points stopped")
    rig.say("hey robot")
    rig.run(0.5)
    assert rig.executor.snapshot.mode.state is State.ACTIVE


@pytest.mark.parametrize("phase", ["open", "reach", "close", "pull"])
def test_a_phase_that_takes_too_long_brakes(phase):
    rig = Rig(config=with_watchdogs(phase_timeout=2.0)).moving(phase)
    rig.now += 3.5  # in which the way, late for once, goes on by five periods only
    rig.until(lambda: rig.state is State.FAULTED, limit=0.5)
    assert "s longer than planned, allowed 2 s" in rig.view.mode.reason
    assert rig.view.mode.cause.reason is Reason.OVERTIME


def test_a_long_way_may_take_its_time():
    rig = Rig(config=with_watchdogs(phase_timeout=2.0)).awake()
    start = rig.now
    rig.finish("withdraw")
    assert rig.now - start > 10.0


def test_a_shaft_off_the_trocar_brakes():
    config = shared()[0]
    registration = replace(config.rcm.registration, tolerance=1e-6)
    rcm = replace(config.rcm, measured_tolerance=1e-6, registration=registration)
    rig = Rig(config=replace(config, rcm=rcm))
    rig.moving("reach")
    rig.robot.push(np.full(10, 1e-3))
    rig.robot.servo_jp = lambda setpoint: None
    rig.until(lambda: rig.state is State.FAULTED, limit=0.5)
    assert "off the trocar" in rig.view.mode.reason


def test_stale_joint_states_at_rest_refuse_motion_but_latch_nothing():
    rig = Rig().awake()
    rig.robot.freeze()
    rig.run(0.05)
    assert rig.state is State.ACTIVE
    assert "old" in rig.refused("tense")
    rig.robot.thaw()
    rig.run(0.01)
    rig.say("tense")


def test_over_tension_can_be_eased_after_hey_robot():
    rig = Rig().moving("pull")
    fault_in_motion(rig, _stiffen)
    assert rig.view.tension > rig.config.controller.tension.limit
    rig.say("hey robot")
    rig.refused("pull more")
    rig.finish("release")
    assert rig.view.tension == 0.0


@pytest.mark.parametrize("amounts", [{}, {"distance": 0.0005}])
def test_pull_less_eases_a_tension_over_its_limit(amounts):
    rig = Rig().moving("pull")
    tissue, limit = rig.robot.tissue, rig.config.controller.tension.limit
    rig.until(lambda: rig.view.tension > 0.9)
    tissue.stiffness *= 1.02 * limit / rig.view.tension
    rig.until(lambda: rig.state is State.FAULTED)
    assert rig.view.tension > limit
    rig.say("hey robot")
    assert rig.finish("pull less", **amounts).tension < limit


def test_the_event_of_a_stop_says_when_it_came_not_when_it_was_taken_up_and_from_whom():
    rig = Rig().awake()
    came = rig.now + 0.0007
    rig.executor.stop(Cause(Reason.STOP_TOPIC, "test"), came, "/pedal")
    rig.tick()
    event = next(entry for entry in rig.executor.events if entry.kind == "stop_received")
    assert event.stamp == came < rig.now
    assert event.caller == "/pedal"
    assert rig.state is State.HALTED
