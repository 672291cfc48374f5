# SPDX-License-Identifier: BSD-3-Clause
"""A 6-DoF arm with a longer shaft: the same code, by its URDF and settings alone."""

from itertools import product

import numpy as np
import pytest

from bench.motion.bullet.robot import BulletRobot
from bench.motion.paths import by_bullet, by_kdl, random_paths, shaft_error
from rst_control.assembly import make_trocar_context
from rst_control.config import SimulationConfig
from rst_control.description.facts import load_facts
from rst_control.description.urdf_writer import urdf_text
from rst_control.errors import RobotModelError
from rst_control.kinematics import forward, manipulability
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.kinematics.robot_model import parse_robot
from rst_control.planning.planner import Planner
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.trajectory.motion_profile import MotionProfile
from rst_control.types import PathState
from tests.property.six_joints import EXAMPLE, URDF, example, settings_of
from tests.support.changed_settings import planner_with
from tests.support.jacobians import differences, rcm_jacobian_at
from tests.unit.rst_control.support.executor_rig import Rig

PATHS = 40
MOST_ERROR = 1e-6  # [m]
LACKING = 6  # number in q of the joint that the arm does not have


@pytest.fixture(scope="module")
def planner():
    config, model = example()
    return Planner(model, config)


@pytest.fixture(scope="module")
def paths(planner):
    return [path for path, _ in random_paths(planner, PATHS, seed=4, spread=0.3)]


def test_the_urdf_is_written_from_its_numbers():
    written = urdf_text(load_facts(EXAMPLE / "robot.yaml"))
    assert URDF.read_text(encoding="utf-8") == written


def test_the_model_knows_which_joint_is_lacking_and_how_long_the_shaft_is(planner):
    assert planner.model.locked == (LACKING,)
    assert planner.model.shaft_length == pytest.approx(0.36, abs=1e-12)


def test_a_joint_that_is_fixed_without_saying_so_is_refused():
    text = URDF.read_text(encoding="utf-8").replace("locked_joint_7", "flange")
    with pytest.raises(RobotModelError, match="joints up to tool_tip"):
        parse_robot(text)


def test_more_of_the_shaft_than_there_is_cannot_be_asked_for(planner):
    words = r"rcm.insertion up to 0.4 m, allowed: the shaft, 0.36"
    with pytest.raises(RobotModelError, match=words):
        planner_with(planner, rcm={"insertion": (0.05, 0.40)})


def test_the_lacking_joint_moves_nothing_and_has_no_column(planner):
    home = np.array(planner.config.scene.home)
    turned = home + np.eye(9)[LACKING]
    np.testing.assert_array_equal(
        Configuration(planner.model, home).T_base_tip,
        Configuration(planner.model, turned).T_base_tip,
    )
    here = Configuration(planner.model, home)
    assert not here.J_tip[:, LACKING].any()
    assert not rcm_jacobian_at(here, planner.trocar)[:, LACKING].any()
    assert manipulability.measure(planner.model.chain, home, planner.trocar) > 1e-7


def test_jacobians_are_finite_differences(planner):
    for q in np.random.default_rng(2).uniform(-1.5, 1.5, (20, 9)):
        J = Configuration(planner.model, q).J_tip[:3]
        slopes = differences(lambda x: Configuration(planner.model, x).tip, q)
        np.testing.assert_allclose(J, slopes, atol=1e-8)


def test_random_paths_stay_in_the_trocar_by_kdl_and_by_pybullet(planner, paths):
    rng, worst = np.random.default_rng(9), [0.0, 0.0]
    with BulletRobot(URDF) as robot:
        shafts = by_kdl(planner.model), by_bullet(robot)
        for path in paths:
            samples = path.sample(planner.model.chain, planner.trocar, per_knot=20)
            chosen = np.append(rng.integers(0, len(samples.s), 20), samples.rcm_error.argmax())
            for k, (n, shaft) in product(chosen, enumerate(shafts)):
                joints = robot_joints(samples.q[k, 0], 0.0)
                assert joints[LACKING] == 0.0
                worst[n] = max(worst[n], shaft_error(shaft(joints), planner.trocar))
    assert worst[0] <= MOST_ERROR
    assert worst[1] <= MOST_ERROR


def test_paths_keep_joint_limits_and_speeds(planner, paths):
    for path in paths[:20]:
        samples = path.sample(planner.model.chain, planner.trocar)
        bounds = planner.pace(path, planner.config.controller.speed.tip_speed).moving
        for q in (samples.q[:, 0].min(axis=0), samples.q[:, 0].max(axis=0)):
            planner.limits.require(q)
        rates = np.abs(samples.q[:, 1]) * bounds.speed
        assert (rates <= planner.limits.velocity + 1e-9).all()
        profile = MotionProfile(PathState(0.0), bounds)
        profile.go_to(path.length)
        assert 0.0 < profile.remaining < 60.0


def test_all_commands_are_carried_out_in_the_trocar(planner):
    """The whole controller on a robot that reaches its set-points, each judged by KDL."""
    config, model = example()
    rig, tensions = Rig(config=config, context=make_trocar_context(config, model)).awake(), []
    for words in ("tense", "pull more", "pull less", "release"):
        rig.finish(words)
        tensions.append(rig.robot.measured_js().tension)
    assert tensions[0] == pytest.approx(config.controller.tension.initial, abs=0.03)
    assert tensions[1] > tensions[0] + 0.2
    assert tensions[2] < tensions[1] - 0.2
    assert tensions[3] == 0.0
    kdl, sent = by_kdl(model), [s.position for s in rig.sent if s is not None]
    assert len(sent) > 1000
    assert max(shaft_error(kdl(q), planner.trocar) for q in sent[::5]) <= MOST_ERROR
    assert {float(q[LACKING]) for q in sent} == {0.0}


def test_it_is_simulated_from_its_own_urdf_and_holds():
    config = settings_of(SimulationConfig, ("limits", "scene", "simulator", "plant"))
    home = Configuration(example()[1], np.array(config.scene.home))
    with PybulletRobot(config, URDF) as robot:
        robot.advance(until=0.5)
        assert not robot.fault
        np.testing.assert_allclose(robot.reading.position[:9], config.scene.home, atol=1e-6)
        assert robot.reading.position[LACKING] == 0.0
        first, last = robot.shaft()
    np.testing.assert_allclose(first, home.frames[forward.SHAFT, :, 3], atol=1e-6)
    np.testing.assert_allclose(last, home.frames[forward.PITCH, :, 3], atol=1e-6)


def test_frames_of_joints_that_turn_are_rotations(planner):
    frames = Configuration(planner.model, planner.config.scene.home).frames
    for row in (*range(LACKING), forward.PITCH, forward.SHAFT, forward.TOOL0, forward.TIP):
        R = frames[row, :, :3]
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
