# SPDX-License-Identifier: BSD-3-Clause
"""The table of checks that move nothing, on the stand-in of the drivers and with each fault."""

from dataclasses import replace

import numpy as np
import pytest

from bench.kinova.rig import KinovaRig, kinova_motion
from rst_control.config import URDF_FILE
from rst_control.kinova.arm_state import ArmState, Banks
from rst_control.kinova.feedback import FeedbackReader
from rst_control.kinova.live_checks import LiveChecks, Observed, table
from tests.support.other_tool import tool_beside

SECONDS = 1.0
ARM, TOOL = "/my_gen3/driver", "/openrst_control"
PUBLISHERS = {
    "/my_gen3/base_feedback/joint_state": [ARM],
    "/my_gen3/in/joint_velocity": ["/kinova_bridge", "/kinova_guard"],
}
ROWS = ("position", "velocity", "effort")  # of joint states
SUBSCRIBERS = {"/my_gen3/in/joint_velocity": [ARM], "/my_gen3/in/stop": [ARM]}


def feedback(rig, kinova, steps):
    """What the stand-in reports within so many milliseconds."""
    arm = kinova.bridge.arm
    reader, found = FeedbackReader(arm.joints, (1.0,) * 7, kinova.first_turns), []
    for count in range(steps):
        rig.drivers.step()
        rig.robot.step()
        reading = rig.drivers.arm_feedback() if count % 25 == 0 else None
        if reading is not None:
            values = {row: getattr(reading, row) for row in ROWS}
            found.append(reader.read(arm.joints, values, rig.now))
    return found


def tool_feedback(rig, kinova):
    tool = kinova.bridge.tool
    values = dict.fromkeys(ROWS, np.zeros(3))
    return FeedbackReader(tool.joints, tool.signs, None).read(tool.joints, values, rig.now)


@pytest.fixture(scope="module")
def rig():
    with KinovaRig(kinova_motion()) as rig:
        yield rig


@pytest.fixture(scope="module")
def seen(rig, kinova):
    return Observed(
        SECONDS,
        arm=feedback(rig, kinova, 1000),
        reports=[rig.drivers.arm_report()],
        limits=rig.drivers.soft_limits(),
        firmware="2.5.2",
        clock=0.01,
        tool=tool_feedback(rig, kinova),
        tool_state=3,
        guard_beats=50,
        forces=[np.full(3, 0.01)] * 100,
        publishers=PUBLISHERS,
        subscribers=SUBSCRIBERS,
    )


@pytest.fixture(scope="module")
def checks(kinova, motion_config):
    trocar = np.array(motion_config.scene.trocar)
    return LiveChecks(kinova, trocar, URDF_FILE.read_text(encoding="utf-8"), 1e-3)


def failed(results):
    return {result.name: result.found for result in results if result.is_met is False}


def test_drivers_that_are_well_pass_all_checks(checks, seen):
    results = checks(seen)
    assert failed(results) == {}
    assert [result.is_met for result in results] == [True] * len(results)


def test_the_shaft_is_that_of_the_tool_that_is_described(kinova, motion_config, seen):
    checks = LiveChecks(kinova, np.array(motion_config.scene.trocar), tool_beside(0.01), 1e-3)
    assert failed(checks(seen))["shaft is in the trocar"].startswith("10.")


def of_arm(seen, **rows):
    return replace(seen, arm=[replace(state, **rows) for state in seen.arm])


def moved(seen, joint, by):
    return replace(
        seen,
        arm=[replace(s, position=s.position + by * np.eye(7)[joint - 1]) for s in seen.arm],
    )


def with_other(seen, topic, node):
    topic = f"/my_gen3/{topic}"
    return replace(seen, publishers={**PUBLISHERS, topic: [*PUBLISHERS.get(topic, []), node]})


def with_report(seen, **fields):
    return replace(seen, reports=[*seen.reports, replace(seen.reports[0], **fields)])


FAULTS = {
    "arm reports its joints": [
        lambda s: replace(s, arm=(), bad_feedback="joint state without joint_3"),
        lambda s: replace(s, arm=s.arm[::2]),
    ],
    "no state is late": [lambda s: replace(s, arm=[*s.arm[:20], *s.arm[24:]])],
    "tool reports its joints": [
        lambda s: replace(s, tool=None),
        lambda s: replace(s, tool=None, bad_tool="joint state without joint_f0_pitch"),
    ],
    "states are new ones": [
        lambda s: replace(s, arm=[replace(s.arm[0], stamp=a.stamp) for a in s.arm])
    ],
    "arm is ready and nobody has it": [
        lambda s: replace(s, reports=()),
        lambda s: with_report(s, state=ArmState.IN_FAULT),
        lambda s: with_report(s, base=Banks(0x800000)),
        lambda s: with_report(s, state=ArmState.SERVOING_MANUALLY_CONTROLLED, connection=8),
        lambda s: with_report(s, state=ArmState.INITIALIZATION),
    ],
    "arm's soft limits are enough": [
        lambda s: replace(s, limits=None),
        lambda s: replace(s, limits=replace(s.limits, acceleration=np.full(7, 0.5))),
        lambda s: replace(s, limits=replace(s.limits, speed=np.full(7, 0.1))),
    ],
    "clocks of the hosts agree": [lambda s: replace(s, clock=-3600.0)],
    "one believed driver reports": [
        lambda s: with_other(s, "base_feedback/joint_state", "/play_1234"),
        lambda s: replace(s, publishers={}),
    ],
    "driver takes velocities and stops": [lambda s: replace(s, subscribers={})],
    "nobody else moves the arm": [
        lambda s: with_other(s, "in/joint_velocity", "/rostopic_1"),
        lambda s: with_other(
            s, "gen3_joint_trajectory_controller/follow_joint_trajectory/goal", "/moveit"
        ),
    ],
    "arm rests": [lambda s: of_arm(s, velocity=np.full(7, 0.1))],
    "joints are within their limits": [lambda s: moved(s, 2, 2.6)],
    "joints are in the turn of home": [lambda s: moved(s, 7, 6.28)],
    "torques at rest are gravity's": [
        lambda s: replace(s, arm=[replace(a, effort=-a.effort) for a in s.arm])
    ],
    "shaft is in the trocar": [lambda s: moved(s, 6, 0.01)],
    "tool holds its position": [
        lambda s: replace(s, tool_state=None),
        lambda s: replace(s, tool_state=1),
        lambda s: replace(s, tool_state=9),
    ],
    "tension is measured": [
        lambda s: replace(s, forces=()),
        lambda s: replace(s, forces=[np.full(3, np.nan)]),
    ],
}


@pytest.mark.parametrize(
    ("name", "fault"), [(name, fault) for name, faults in FAULTS.items() for fault in faults]
)
def test_each_fault_is_named_with_its_next_step(checks, seen, name, fault):
    results = checks(fault(seen))
    assert name in failed(results)
    line = next(line for line in table(results).splitlines() if name in line)
    assert line.startswith("NO") and "  -> " in line


def test_a_reply_that_the_driver_lost_shows(rig, kinova, checks, seen):
    before = feedback(rig, kinova, 400)
    rig.drivers.lose_reply(0.3)
    found = failed(checks(replace(seen, arm=[*before, *feedback(rig, kinova, 600)])))
    assert set(found) == {"arm reports its joints", "no state is late"}


def test_warnings_of_the_arm_are_shown_and_refuse_nothing(checks, seen):
    results = checks(with_report(seen, warnings=("base: maximum ambient temperature",)))
    assert failed(results) == {}
    assert "warnings: base: maximum ambient temperature" in table(results)


BRIDGE = "/kinova_bridge"


@pytest.mark.parametrize(
    ("beats", "is_connected", "publishers", "is_met", "words"),
    [
        (0, True, None, None, "master"),
        (0, False, {}, None, "kinova.launch starts it"),
        (0, True, {}, True, "runs, waits for the bridge"),
        (0, True, {"/kinova_bridge/beat": [BRIDGE]}, False, "does not hear /kinova_bridge"),
        (0, False, {"/kinova_bridge/beat": [BRIDGE]}, None, "kinova.launch starts it"),
        (50, True, {"/kinova_bridge/beat": [BRIDGE]}, True, "hears the bridge"),
    ],
)
def test_the_stop_guard_is_said_to_be_well_only_as_far_as_is_known(
    checks, seen, beats, is_connected, publishers, is_met, words
):
    guard = {"guard_beats": beats, "is_guard_connected": is_connected, "publishers": publishers}
    row = checks(replace(seen, **guard))[-1]
    assert (row.name, row.is_met) == ("stop guard is there", is_met)
    assert words in row.found
    assert "ROS_IP" in row.next_step or is_met is not False


@pytest.mark.parametrize("is_named", [True, False])
def test_a_system_in_a_namespace_has_its_own_drivers_and_nodes(
    kinova, motion_config, seen, is_named
):
    def below(names):
        return {f"/left{topic}": [f"/left{node}" for node in names[topic]] for topic in names}

    trocar, text = np.array(motion_config.scene.trocar), URDF_FILE.read_text(encoding="utf-8")
    named = "/left{}".format if is_named else str
    results = LiveChecks(kinova, trocar, text, 1e-3, named)(
        replace(seen, publishers=below(PUBLISHERS), subscribers=below(SUBSCRIBERS))
    )
    assert (failed(results) == {}) is is_named


@pytest.mark.parametrize("beats", [(), ("/kinova_bridge",)])
@pytest.mark.parametrize("topic", ["in/stop", "in/joint_velocity"])
def test_a_stop_guard_of_another_arm_is_named(checks, seen, topic, beats):
    own = {f"/my_gen3/{one}": ["/kinova_guard"] for one in ("in/stop", "in/joint_velocity")}
    publishers = {"/kinova_guard/alive": ["/kinova_guard"], "/kinova_bridge/beat": beats, **own}
    guard = {"guard_beats": 0, "is_guard_connected": True}
    row = checks(replace(seen, **guard, publishers=publishers))[-1]
    assert row.is_met is (not beats)
    assert "or the driver does not hear it" in row.found or not beats
    astray = {**publishers, f"/my_gen3/{topic}": ["/kinova_bridge"]}
    row = checks(replace(seen, **guard, publishers=astray))[-1]
    assert (row.is_met, row.found) == (False, "/kinova_guard guards another arm than my_gen3")
    assert "arm:=" in row.next_step


def test_of_silent_drivers_and_a_silent_master_nothing_is_said_to_be_well(checks):
    results = checks(Observed(SECONDS))
    assert not any(result.is_met for result in results)
    assert len(table(results).splitlines()) == len(results)
