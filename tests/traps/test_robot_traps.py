# SPDX-License-Identifier: BSD-3-Clause
"""Faults that others met between command and motion; `README.md` here lists the tests of all."""

import math
import re
from dataclasses import replace

import numpy as np
import pybullet
import pytest

from demo.check import Observed, worst_rcm_error
from rst_control.config import load_motion_config, load_simulation_config
from rst_control.errors import RstError, TrocarDrift
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.planner import Planner
from rst_control.simulation.physics import joint_indices
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.simulation.tissue import SimulatedTissue
from rst_control.trajectory.path import Path
from rst_control.types import JOINTS
from support.figures import Figure, percentiles
from typed_config import ConfigError

SIMULATION, MOTION = load_simulation_config(), load_motion_config()


@pytest.fixture(scope="module")
def planner():
    return Planner(load_robot(), MOTION)


def simulator(**changes):
    return replace(SIMULATION, simulator=replace(SIMULATION.simulator, **changes))


def some_path(planner):
    """A path that passes every check."""
    path = planner.reach(np.array(MOTION.scene.home))[0]
    assert planner._checked(path) is path
    return path


@pytest.mark.parametrize("where", [0, 3, -1])
def test_a_path_whose_rcm_error_is_no_number_does_not_pass(planner, where):
    """A check "error > limit" is false for what was never computed: it must ask the other way."""
    path = some_path(planner)
    knots = np.array(path.knots)
    knots[where, 1] = math.nan
    broken = Path(knots, path.slopes, path.length)
    with pytest.raises(RstError):
        planner._checked(broken)
    samples = path.sample(planner.model.chain, planner.trocar)
    unknown = broken.sample(planner.model.chain, planner.trocar).rcm_error
    with pytest.raises(TrocarDrift):
        planner.checks.rcm(replace(samples, rcm_error=unknown))


def test_a_path_of_no_length_does_not_pass_unseen(planner):
    """Sampled at no spacing a path shows no numbers; that is no proof that it keeps the trocar."""
    path = some_path(planner)
    with pytest.raises((RstError, ZeroDivisionError)), np.errstate(all="ignore"):
        planner._checked(Path(path.knots, path.slopes, 0.0))


def test_a_stray_between_two_good_knots_is_seen(planner):
    """Checking the knots alone says nothing about the way between them."""
    path = some_path(planner)
    slopes = np.array(path.slopes)
    slopes[3, 1] += 2.0
    strayed = Path(path.knots, slopes, path.length)
    samples = strayed.sample(planner.model.chain, planner.trocar, per_knot=1)
    assert samples.rcm_error.max() < MOTION.rcm.planned_tolerance
    with pytest.raises(TrocarDrift):
        planner._checked(strayed)


def test_figures_of_nothing_are_not_met():
    """No samples must not look like an error of zero, in the bench or in the demonstration."""
    assert not Figure("rcm", math.nan, "um", 10.0).is_met
    assert not Figure("share", math.nan, "", 0.99, at_most=False).is_met
    with pytest.raises(ValueError, match="rcm: no values"):
        percentiles("rcm", [], "um", {50: 10.0})
    assert math.isnan(worst_rcm_error(Observed()))


def reaction(load):
    """Force that a sensor in the arm's last joint feels under a load at the tip [N]. Shape (3,)."""
    with PybulletRobot(simulator(tool_load=load)) as robot:
        physics = robot._physics
        body, client = physics._robot, physics._client
        joint = joint_indices(body, client)[JOINTS.index("joint_7")]
        pybullet.enableJointForceTorqueSensor(body, joint, 1, physicsClientId=client)
        robot.advance(0.3)
        return np.array(pybullet.getJointState(body, joint, physicsClientId=client)[2][:3])


def test_two_newtons_at_the_tip_read_as_two_newtons():
    """A soft body anchored to a link loads no joint in PyBullet; a force at the tip does."""
    felt = float(np.linalg.norm(reaction(2.0) - reaction(0.0)))
    assert felt == pytest.approx(2.0, abs=5e-5)


def test_held_tissue_reports_the_force_of_its_stretch():
    """An anchor that reports no force would leave the tension at zero, and the pull without end."""
    tissue = SimulatedTissue(SIMULATION.scene.tissue, 0.001)
    tip = np.array(SIMULATION.scene.tissue.reference_point)
    assert tissue.grasp(tip)
    pull = np.array(SIMULATION.scene.tissue.reference_pull)
    for share in np.linspace(0.0, 1.0, 400):
        force = tissue.advance(tip + share * pull)
    for _ in range(400):
        force = tissue.advance(tip + pull)
    expected = SIMULATION.scene.tissue.stiffness * np.linalg.norm(pull)
    assert np.linalg.norm(force) == pytest.approx(expected, rel=0.1)
    assert force @ pull < 0.0


@pytest.mark.parametrize("rate", [1000.0, 500.0])
def test_the_physics_runs_at_the_rate_of_the_settings(rate):
    """PyBullet steps at 240 Hz by default, where the RCM error of motion is 20 times larger."""
    with PybulletRobot(simulator(physics_rate=rate)) as robot:
        parameters = pybullet.getPhysicsEngineParameters(physicsClientId=robot._physics._client)
        assert parameters["fixedTimeStep"] == robot.time_step == 1.0 / rate
        robot.advance(0.01)
        assert robot.now == pytest.approx(0.01)


def test_the_shipped_physics_runs_at_a_kilohertz():
    """A lower rate must be set; the comment of that setting names what it costs."""
    assert SIMULATION.simulator.physics_rate == 1000.0


@pytest.mark.parametrize("rate", [240.0, 750.0, 400.0])
def test_a_physics_rate_that_would_change_the_rate_of_publishing_is_refused(rate):
    """At 240 Hz nothing can be published 500 times a second; that must not pass in silence."""
    words = re.escape("a whole multiple of publish_rate, 500 Hz")
    with pytest.raises(ConfigError, match=words):
        simulator(physics_rate=rate)
