# SPDX-License-Identifier: BSD-3-Clause
"""Whatever stops the robot is in the event log that gets recorded, with its cause.

The controller runs without ROS on a robot without physics. Each event becomes, field
by field, a message of `rst_control/event`, and its view one of `rst_control/state`: both recorded.
"""

from pathlib import Path

import numpy as np
import pytest
import yaml

from rst_control.types import LATCHED, Cause, Reason, State
from tests.unit.rst_control.support.executor_rig import Rig

ROOT = Path(__file__).resolve().parents[4]
RECORDER = ROOT / "catkin_ws/src/session_log/config/recorder.yaml"


def push(rig):
    rig.robot.servo_jp = lambda setpoint: None
    rig.robot.push(np.full(10, 0.06))


def stiffen(rig):
    rig.until(lambda: rig.view.tension > 0.9)
    rig.believing()  # a tension that leaps is a sensor's fault to the watch over the sensors
    limit = rig.config.controller.tension.limit
    rig.robot.tissue.stiffness *= 1.02 * limit / rig.view.tension


def stop(reason, words="stopped by voice"):
    return lambda rig: rig.executor.stop(Cause(reason, words))


def error(rig):
    rig.executor.crashed(ArithmeticError("not a number"))


def two_errors(rig):
    error(rig)
    rig.executor.crashed(ArithmeticError("still not a number"))


UNRECORDED = "not recorded: recorder silent for 1.2 s, allowed 1.0 s"
IN_MOTION = {  # faults of the robot: test_watchdogs.py
    Reason.SENSOR_FAULT: push,
    Reason.OVER_TENSION: stiffen,
    Reason.STOP_TOPIC: stop(Reason.STOP_TOPIC),
    Reason.STOP_COMMAND: lambda rig: rig.say("stop"),
    Reason.STOP_CANCEL: stop(Reason.STOP_CANCEL, 'stop by cancelling the action "tense"'),
    Reason.NOT_RECORDED: stop(Reason.NOT_RECORDED, UNRECORDED),
    Reason.SHUTDOWN: stop(Reason.SHUTDOWN, "the controller is being shut down"),
    Reason.LOOP_ERROR: two_errors,
}
LATCHES = (Reason.SENSOR_FAULT, Reason.STOP_TOPIC, Reason.SHUTDOWN)
AT_REST = {reason: IN_MOTION[reason] for reason in LATCHES} | {Reason.LOOP_ERROR: error}


def latched(rig):
    return rig.executor._mode.state in LATCHED


def events(rig):
    """The events so far, which is published and recorded."""
    return list(rig.executor.events)


def causes(messages):
    return {m.reason for m in messages if m.kind == "halted"}


@pytest.mark.parametrize("reason", IN_MOTION)
def test_what_stops_a_motion_is_in_the_event_log_and_in_the_state_with_its_cause(reason):
    rig = Rig().moving("pull")
    IN_MOTION[reason](rig)
    rig.until(lambda: latched(rig), limit=2.0)
    rig.tick()
    assert causes(events(rig)) == {reason}
    assert rig.view.mode.is_latched
    assert rig.view.mode.cause.reason is reason


@pytest.mark.parametrize("reason", AT_REST)
def test_what_latches_a_robot_at_rest_is_in_the_event_log_with_its_cause(reason):
    rig = Rig().awake()
    AT_REST[reason](rig)
    rig.until(lambda: latched(rig), limit=2.0)
    assert causes(events(rig)) == {reason}


def test_a_fault_that_follows_a_stop_at_rest_is_in_the_event_log_too():
    rig = Rig().awake()
    AT_REST[Reason.STOP_TOPIC](rig)
    rig.until(lambda: latched(rig))
    rig.robot.fault = "brakes on"
    rig.until(lambda: rig.state is State.FAULTED, limit=1.0)
    assert causes(events(rig)) == {Reason.STOP_TOPIC, Reason.FAULTED}


def test_a_loop_that_fails_again_and_again_still_reports_its_state():
    rig = Rig().moving("reach")

    def fail(joints):
        raise ArithmeticError("not a number")

    rig.executor._robot.trocar_pose_of = fail
    before = rig.view.stamp
    for _ in range(5):
        with pytest.raises(ArithmeticError) as raised:
            rig.tick()
        rig.executor.crashed(raised.value)
    assert rig.view.mode.state is State.FAULTED and "not a number" in rig.view.mode.reason
    assert rig.view.stamp > before
    assert causes(events(rig)) == {Reason.LOOP_ERROR}


def test_a_motion_that_is_given_up_says_why_when_it_has_come_to_rest():
    rig = Rig().awake()
    rig.robot.tissue = None
    rig.say("tense")
    rig.until(lambda: rig.state is State.ACTIVE, limit=30.0)
    rest = [m for m in events(rig) if m.kind == "at_rest"]
    assert [m.reason for m in rest] == [Reason.CLOSED_ON_NOTHING]


def test_who_terminates_a_motion_is_in_the_event_log():
    rig = Rig().moving("pull")
    rig.say("terminate")
    rig.rest()
    found = [(m.kind, m.message, m.reason) for m in events(rig)]
    assert ("at_rest", "terminated", Reason.TERMINATED) in found
    assert "terminate" in [m.command for m in events(rig) if m.kind == "accepted"]


def test_the_recorder_is_there_before_the_first_stop_refusal_or_alarm():
    early = set(yaml.safe_load(RECORDER.read_text(encoding="utf-8"))["subscribe_early"])
    state = {"/rst_control/event", "/rst_control/state", "/rst_control/stop"}
    voice = {"/voice_assist/alarm", "/voice_assist/utterance"}
    assert state | voice | {"/diagnostics", "/rosout", "/robot/fault"} <= early
