# SPDX-License-Identifier: BSD-3-Clause
"""Camera steps under the trocar: left is left in the picture, and the shaft stays where it is."""

import numpy as np
import pytest

from bench.motion.insertion import situation
from rst_control.commands.camera_step import CAMERA_STEPS, STEPS, picture, step_goal
from rst_control.commands.table import COMMANDS
from rst_control.commands.verifier import Verifier
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.planning.plan import PhaseKind
from rst_control.types import Reason, Rejected, State
from tests.support.changed_settings import planner_with
from tests.unit.rst_control.support.executor_rig import Rig, shared
from tests.unit.rst_control.support.situations import request

SINGLE = 2e-6  # [m] of PyBullet's single precision, over the length of the arm
ROUND = tuple(c for c in CAMERA_STEPS if not STEPS[c.phrase][2])  # the eight directions
OPPOSITE = {tuple(np.negative(step)): phrase for phrase, step in STEPS.items()}
BACK = {c: COMMANDS[OPPOSITE[STEPS[c.phrase]]] for c in CAMERA_STEPS}


def ask(verify, command, q):
    return verify(request(command.phrase), situation(q))


def in_picture(T_before, tip, roll=0.0):
    """How far a tip moved right, up and forward in the picture [m]."""
    seen = picture(T_before, roll)
    moved = tip - T_before[:3, 3]
    return np.array([moved @ seen.right, moved @ seen.up, moved @ seen.forward])


def test_the_picture_is_a_right_handed_frame_that_looks_where_the_tool_points():
    T = np.eye(4)
    for roll in (0.0, 0.5, -2.0):
        seen = picture(T, roll)
        np.testing.assert_allclose(np.cross(seen.right, -seen.up), seen.forward, atol=1e-15)
        np.testing.assert_allclose(seen.forward, [0.0, -1.0, 0.0], atol=1e-15)
    quarter = picture(T, np.pi / 2)  # turned clockwise: what was at the right is above
    np.testing.assert_allclose(quarter.up, picture(T, 0.0).right, atol=1e-15)


def tip_by(witness, q):
    """Pose of the tool's tip (3, 4) as PyBullet sees it."""
    witness.place(robot_joints(q, 0.0))
    return witness.poses(["tool_tip"])[0]


@pytest.mark.parametrize("command", ROUND)
def test_each_direction_is_that_of_the_picture_and_keeps_the_trocar(
    verify, witness, planner, home, command
):
    """Judged by PyBullet's kinematics, at the end of the planned way and all along it."""
    plan = ask(verify, command, home).plan
    assert {phase.kind for phase in plan.phases} == {PhaseKind.CAMERA_STEP}
    before, after = (tip_by(witness, q) for q in (home, plan.phases[-1].path.end))
    right, up, _ = in_picture(before, after[:, 3])
    wanted = np.array(STEPS[command.phrase][:2]) / np.linalg.norm(STEPS[command.phrase][:2])
    moved = np.array([right, up]) / np.hypot(right, up)
    assert np.hypot(right, up) > 0.007
    assert float(moved @ wanted) > np.cos(0.25), (right, up)
    signs = [int(np.sign(x)) if abs(x) > 3e-3 else 0 for x in (right, up)]
    assert signs == list(STEPS[command.phrase][:2])
    for phase in plan.phases:
        samples = phase.path.sample(planner.model.chain, planner.trocar, per_knot=20)
        assert samples.rcm_error.max() < 1e-6
        for q in samples.q[::40, 0]:
            assert witness.observe(q).error < SINGLE


@pytest.mark.parametrize("command", ROUND)
def test_a_step_sideways_turns_the_tool_as_one_about_the_trocar(verify, planner, home, command):
    camera = planner.config.controller.camera
    end = ask(verify, command, home).plan.phases[-1].path.end
    before, after = (Configuration(planner.model, q) for q in (home, end))
    shafts = [c.T_base_shaft[:3, 2] for c in (before, after)]
    assert np.arccos(shafts[0] @ shafts[1]) <= camera.angle + 1e-9
    arms = [c.tip - planner.trocar for c in (before, after)]
    turned = np.arccos(arms[0] @ arms[1] / np.prod([np.linalg.norm(a) for a in arms]))
    assert turned == pytest.approx(camera.angle, abs=1e-6)
    np.testing.assert_allclose(after.q[7:], home[7:], atol=1e-5)  # the wrist keeps its bend
    depths = [planner.patient.trocar_pose(c.q).wrist for c in (before, after)]
    assert depths[0] == pytest.approx(depths[1], abs=1e-7)


@pytest.mark.parametrize(
    ("command", "sign"), [(COMMANDS["look closer"], 1), (COMMANDS["look wider"], -1)]
)
def test_closer_and_wider_slide_along_the_shaft(verify, witness, planner, home, command, sign):
    decision = ask(verify, command, home)
    path = decision.plan.phases[-1].path
    before = Configuration(planner.model, home)
    moved = tip_by(witness, path.end)[:, 3] - before.tip
    shaft = before.T_base_shaft[:3, 2]
    np.testing.assert_allclose(
        moved, sign * planner.config.controller.camera.depth * shaft, atol=SINGLE
    )
    depths = [planner.patient.trocar_pose(q).wrist for q in (home, path.end)]
    assert depths[1] - depths[0] == pytest.approx(sign * 0.010, abs=1e-7)
    assert path.sample(planner.model.chain, planner.trocar).rcm_error.max() < 1e-6


@pytest.mark.parametrize("command", CAMERA_STEPS)
def test_the_opposite_step_leads_back(verify, planner, home, command):
    there = ask(verify, command, home).plan.phases[-1].path.end
    back = ask(verify, BACK[command], there).plan.phases[-1].path.end
    tips = [Configuration(planner.model, q).T_base_tip for q in (home, back)]
    np.testing.assert_allclose(*tips, atol=1e-8)


def test_the_camera_may_sit_turned_on_the_tool(planner, home):
    """Turned by a quarter, what was left for the first camera is up for the other."""
    turned = planner_with(planner, camera={"image_roll": -np.pi / 2})
    np.testing.assert_allclose(
        step_goal(turned, STEPS["look up"], home),
        step_goal(planner, STEPS["look left"], home),
        atol=1e-12,
    )


@pytest.mark.parametrize(
    ("words", "camera", "insertion", "reason"),
    [
        ("look left", {"angle": 0.5}, (0.05, 0.25), Reason.WORKSPACE),
        ("look wider", {"depth": 0.05}, (0.04, 0.25), Reason.WORKSPACE),
        ("look left", {"max_tilt": 0.12}, (0.05, 0.25), Reason.TILT_LIMIT),
        ("look closer", {}, (0.05, 0.105), Reason.INSERTION_DEPTH),
        ("look wider", {}, (0.095, 0.25), Reason.INSERTION_DEPTH),
    ],
)
def test_a_step_that_leads_too_far_is_refused_by_name(
    planner, home, words, camera, insertion, reason
):
    strict = planner_with(planner, camera=camera, rcm={"insertion": insertion})
    decision = ask(Verifier(strict), COMMANDS[words], home)
    assert isinstance(decision, Rejected)
    assert decision.reason is reason and "allowed" in decision.words, decision


def test_a_shaft_that_leans_too_far_may_be_turned_back(robot, planner, verify, home):
    strict, lean = Verifier(planner_with(planner, camera={"max_tilt": 0.05})), {}
    inward = -planner.patient.outward
    before = np.arccos(Configuration(robot, home).T_base_shaft[:3, 2] @ inward)
    assert before > 0.05
    for command in ROUND:
        decision = ask(strict, command, home)
        free = ask(verify, command, home).plan.phases[-1].path.end
        lean[command.phrase] = np.arccos(Configuration(robot, free).T_base_shaft[:3, 2] @ inward)
        if lean[command.phrase] < before:
            assert not isinstance(decision, Rejected), decision
        else:
            assert decision.reason is Reason.TILT_LIMIT
    assert min(lean.values()) < before < max(lean.values())


@pytest.mark.parametrize("command", CAMERA_STEPS)
def test_steps_on_and_on_end_with_a_refusal_and_never_a_drift(verify, planner, home, command):
    q, steps = home, 0
    while not isinstance(decision := ask(verify, command, q), Rejected):
        for phase in decision.plan.phases:
            q = phase.path.end
            assert phase.path.sample(planner.model.chain, planner.trocar).rcm_error.max() < 1e-6
        steps += 1
        assert steps < 30
    assert "allowed" in decision.words


# In the running executor.


def empty_handed():
    """An active rig whose jaws meet no tissue."""
    rig = Rig()
    rig.robot.tissue = None
    return rig.awake()


def test_eight_directions_and_back_by_voice_keep_the_trocar():
    rig = empty_handed()
    first, worst = rig.joints.copy(), 0.0
    for command in (*ROUND, COMMANDS["look closer"]):
        for words in (command.phrase, BACK[command].phrase):
            rig.executor.heartbeat(rig.now)
            pending = rig.say(words, spoken=True)
            while not pending.ended.done():
                rig.executor.heartbeat(rig.now)
                rig.tick()
                worst = max(worst, rig.view.trocar_pose.error)
            assert pending.ended.result(0).kind == "succeeded", pending.ended.result(0)
    planner = shared()[2].planner
    tips = [
        Configuration(planner.model, [*j[:8], 0.5 * (j[8] - j[9])]).tip for j in (first, rig.joints)
    ]
    np.testing.assert_allclose(*tips, atol=1e-7)
    assert worst < 1e-6 and rig.state is State.ACTIVE


def test_stop_in_the_middle_brakes_on_the_way_and_latches():
    rig = empty_handed()
    rig.say("look up left")
    rig.until(lambda: rig.phase == "look" and rig.view.motion.progress > 0.4)
    rig.give("stop")
    assert rig.worst_error_until(lambda: rig.state is not State.STOPPING) < 1e-6
    assert rig.state is State.HALTED
    assert 0.3 < rig.view.path_position / rig.view.path.length < 0.9
    assert rig.still_for(0.2)
    assert "halted" in rig.refused("look right")
    rig.say("hey robot")
    rig.finish("look down right")


def test_a_camera_step_needs_hey_robot_an_inserted_tool_and_empty_jaws():
    rig = Rig().run(0.01)
    assert "hey robot" in rig.refused("look left")
    rig.say("hey robot")
    rig.finish("tense")
    assert "release first" in rig.refused("look left")


def test_another_camera_step_waits_until_the_first_is_done():
    rig = empty_handed()
    rig.say("look left")
    rig.run(0.05)
    assert "busy" in rig.refused("look left")
