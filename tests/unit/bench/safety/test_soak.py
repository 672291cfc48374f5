# SPDX-License-Identifier: BSD-3-Clause
"""The soak's checker: each invariant fires on a made violation, and on nothing else."""

import json
from dataclasses import replace

import numpy as np
import pytest

from bench.safety.soak import suite
from bench.safety.soak.check import SETTLED, CheckedTick, Checker, SoakBounds
from bench.safety.soak.events import FAULTS, TALK, Chance, SoakStanding
from bench.safety.soak.session import Stretch, carried_out, make_bounds
from rst_control.commands.request import Plan
from rst_control.commands.table import COMMANDS
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.planning.patient_surface import TrocarPose
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.robot.setpoint_servo import ServoLimits
from rst_control.types import JOINTS, Cause, ControllerMode, Measurement, Reason, Setpoint, State

ZERO, ONES = np.zeros(10), np.ones(10)
LIMITS = ServoLimits(JOINTS, -ONES, ONES, ONES)
BOUNDS = SoakBounds(
    joints=LIMITS,
    acceleration=10.0 * ONES,
    rcm=1e-3,
    tension=2.4,
    stop=0.4,
    reset_time=0.3,
    period=0.002,
    resting=0.01,
    max_periods=5,
)
STOP = Cause(Reason.STOP_TOPIC, "stop")
ACTIVE, MOVING = ControllerMode(State.ACTIVE, True), ControllerMode(State.MOVING, True)
HALTED = ControllerMode(State.HALTED, True, cause=STOP)
BRAKING = ControllerMode(State.STOPPING, True, State.HALTED, STOP)
OFF = Setpoint(1.5e-3 * np.eye(10)[1], ZERO, 10.002)
TENSE = Plan(COMMANDS["tense"], "pulls", (Phase(PhaseKind.REACH),))


def trocar_pose(position):
    """Off the trocar by what the second joint says."""
    return TrocarPose(abs(float(position[1])), 0.1, 0.1, -0.1, is_outside=False)


def view(mode=ACTIVE, plan=None, position=ZERO):
    measured = Measurement(position, ZERO, ZERO, 0.0)
    return replace(ControllerSnapshot.at_start(), mode=mode, plan=plan, measurement=measured)


def moment(n=0, **changes):
    now = 10.0 + 0.002 * n
    well = CheckedTick(
        now=now,
        before=view(),
        after=view(),
        setpoint=Setpoint(ZERO, ZERO, now),
        position=ZERO,
        velocity=ZERO,
        tension=0.0,
        is_servo_braking=False,
        was_stopped=False,
        said=(),
        is_recorded=True,
    )
    return replace(well, **changes)


def moving(n, at, speed=0.0, **changes):
    """A tick in motion with the first joint at a place [rad] and a speed [rad/s]."""
    first = np.eye(10)[0]
    setpoint = Setpoint(at * first, speed * first, 10.0 + 0.002 * n)
    states = {"before": view(MOVING, TENSE), "after": view(MOVING, TENSE)}
    return moment(n, setpoint=setpoint, **{**states, **changes})


def checked(*moments):
    check = Checker(BOUNDS, trocar_pose)
    for one in moments:
        check(one)
    return dict(check.counts)


def ways(was, now, **changes):
    return moment(1, before=view(was), after=view(now), **changes)


def test_nothing_is_found_where_all_is_well():
    path = [moving(n, 1e-3 * n * n * 0.002, 0.002 * n) for n in range(1, 20)]
    assert checked(moment(), *path) == {}


def test_what_is_taken_anew_is_no_motion():
    there = 0.3 * ONES * np.eye(10)[0]
    anew = moment(1, setpoint=Setpoint(there, ZERO, 10.002), after=view(position=there))
    assert checked(moment(), anew) == {}


@pytest.mark.parametrize(
    ("kind", "moments"),
    [
        ("mode: motion from elsewhere than active", [ways(HALTED, MOVING)]),
        ("mode: motion from elsewhere than active", [ways(BRAKING, MOVING, said=("hey robot",))]),
        ("mode: motion while not activated", [ways(MOVING, ControllerMode(State.MOVING))]),
        ("mode: motion goes on after a stop", [ways(MOVING, MOVING, was_stopped=True)]),
        ('mode: latch lifted without "hey robot"', [ways(HALTED, ACTIVE)]),
        ("mode: braking led elsewhere than it should", [ways(BRAKING, ACTIVE)]),
        ("recording: it advances unrecorded", [moving(1, 0.0, is_recorded=False)]),
        (
            "mode: set-point changes at rest",
            [moment(), moment(1, setpoint=Setpoint(1e-6 * ONES, ZERO, 10.002))],
        ),
        (
            "joint limits: set-point beyond them",
            [moment(setpoint=Setpoint(1.01 * ONES, ZERO, 10.0), after=view(position=1.01 * ONES))],
        ),
        ("joint speed: set-point", [moving(0, 0.0), moving(1, 0.0021)]),
        ("joint acceleration: set-point", [moving(0, 0.0), moving(1, 0.0, 0.021)]),
        ("RCM: set-point", [moving(0, 0.0), replace(moving(1, 0.0), setpoint=OFF)]),
        ("RCM: true shaft", [moment(position=2e-3 * np.eye(10)[1])]),
        ("RCM: true shaft", [moment(position=np.nan * np.eye(10)[1])]),
        ("tension: true", [moment(tension=2.41)]),
        ("tension: true", [moment(tension=float("nan"))]),
        ("joint speed: true", [moment(velocity=1.1 * ONES, is_servo_braking=True)]),
    ],
)
def test_each_invariant_fires_on_a_made_violation(kind, moments):
    assert checked(*moments)[kind] == 1


def test_joints_that_move_while_the_controller_rests_are_found_once_what_was_sent_is_played():
    quick = [moment(n, velocity=0.02 * ONES) for n in range(60)]
    found = checked(moment(is_servo_braking=True), *quick)
    expected = 60 - SETTLED / BOUNDS.period
    assert abs(found["mode: joints move at rest"] - expected) <= 1


def test_a_stop_that_does_not_come_to_rest_is_found():
    stop = ways(MOVING, BRAKING, was_stopped=True)
    on = [ways(BRAKING, BRAKING) for _ in range(250)]
    assert checked(stop, *on)["stop: it takes too long"] == 1
    assert checked(stop, *on[:100], ways(BRAKING, HALTED)) == {}


def test_hey_robot_may_wait_for_the_robot_but_not_across_a_stop():
    asked = moment(0, before=view(HALTED), after=view(HALTED), said=("hey robot",))
    stop = moment(1, before=view(HALTED), after=view(HALTED), was_stopped=True)
    woken = moment(100, before=view(HALTED), after=view(ACTIVE))
    kind = 'mode: latch lifted without "hey robot"'
    assert checked(asked, woken) == {}
    assert checked(asked, stop, woken) == {kind: 1}
    assert checked(asked, replace(woken, now=11.0)) == {kind: 1}


def test_the_bounds_are_those_of_the_settings(motion_config):
    bounds = make_bounds(motion_config)
    assert bounds.tension == motion_config.controller.tension.limit
    assert bounds.rcm == motion_config.rcm.measured_tolerance
    assert bounds.acceleration.shape == bounds.joints.speed.shape == (10,)


def test_chance_draws_everything_and_the_same_with_the_same_seed():
    standing = SoakStanding(True, False, True, False)
    first, again = (Chance(np.random.default_rng(3)) for _ in range(2))
    events = [first.event(standing) for _ in range(2000)]
    assert [e.words for e in events] == [again.event(standing).words for _ in range(2000)]
    assert {e.words for e in events if e.kind == "fault"} == set(FAULTS)
    assert {e.words for e in events if e.kind == "talk"} == set(TALK)
    said = {e.words.strip(" .!,").lower() for e in events if e.kind == "say"}
    assert {"hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate"} <= said


def test_a_short_stretch_breaks_nothing_and_is_the_same_again():
    first, again = (carried_out(Stretch(2, 6.0)) for _ in range(2))
    assert first["counts"] == again["counts"] and first["extremes"] == again["extremes"]
    assert first["ticks"] > 2500 and first["violations"] == {}
    json.dumps(first)


def test_the_summary_counts_every_violation_and_the_growth_of_later_pieces(monkeypatch):
    monkeypatch.setattr(suite, "HOURS", 1.0)

    def report(later, after, violations):
        extremes = dict.fromkeys(("planned_rcm", "speed", "acceleration", "stop"), 0.5)
        extremes |= {"rcm": 2e-4, "tension": 1.0}
        return {
            **{"seconds": 1800.0, "cpu": 90.0, "ticks": 5, "counts": {"say:": 2}},
            **{"rss_before": 100.0, "rss_after": after, "is_later": later},
            **{"violations": violations, "extremes": extremes},
        }

    reports = [report(False, 180.0, {}), report(True, 101.0, {"RCM: true shaft": 2, "x": 1})]
    found = {figure.name: figure for figure in suite.summary(reports)}
    assert (found["measured"].value, found["measured"].target) == (1.0, 24.0)
    assert found["violations of any invariant"].value == 3
    assert found["violations: RCM"].value == 2 and found["violations: others"].value == 1
    assert found["memory growth, mean"].value == pytest.approx(2.0)
    assert found["session time over processor time"].value == pytest.approx(20.0)
    assert found["violations: RCM"].is_met is False and found["violations: mode"].is_met is True


def test_the_key_is_made_of_code_and_settings_of_both_packages(monkeypatch):
    code = {suite._source(name): name for name in suite.PACKAGES}
    settings = {name: suite._settings(name) for name in suite.PACKAGES}
    assert all(len(list(folder.rglob("*.py"))) > 50 for folder in code)
    assert all(len(files) > 5 for files in settings.values())
    monkeypatch.setattr(suite, "code", code.get)
    monkeypatch.setattr(suite, "_settings", settings.get)
    keys = [suite.identity()]
    for made_of in (code, settings):
        for part in made_of:
            monkeypatch.setitem(made_of, part, "other")
            keys.append(suite.identity())
    assert len(set(keys)) == 5
