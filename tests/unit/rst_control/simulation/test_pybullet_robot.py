# SPDX-License-Identifier: BSD-3-Clause
"""The simulated robot: it holds, follows within limits, feels tissue, and says what is wrong."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import SimulationConfig, load_simulation_config
from rst_control.kinematics.configuration import Configuration, planning_joints, robot_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.robot.setpoint_servo import ServoState
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.types import JOINTS, Setpoint
from tests.property.six_joints import URDF, settings_of
from tests.unit.rst_control.support.renamed_links import renamed_urdf
from typed_config import ConfigError

CONFIG = load_simulation_config()
HOME = robot_joints(np.array(CONFIG.scene.home), CONFIG.scene.home_opening)
STILL = np.zeros(10)
TORQUE = np.array([39.0] * 4 + [9.0] * 3 + [1.0] * 3)


def make(start: float = 0.0, **changes) -> PybulletRobot:
    return PybulletRobot(
        replace(CONFIG, simulator=replace(CONFIG.simulator, **changes)), start=start
    )


def swing(robot: PybulletRobot, duration: float, size: np.ndarray, rate: float = 4.0) -> list:
    """Swing the joints about home; joint readings at 1 kHz."""
    readings, begin = [], robot.now
    for _ in range(int(duration / 0.002)):
        t = robot.now - begin
        position = HOME + size * (1.0 - np.cos(rate * t))
        robot.servo_jp(Setpoint(position, size * rate * np.sin(rate * t), robot.now))
        robot.advance(robot.now + 0.002, lambda: readings.append(robot.reading))
    return readings


def turn_jaws(robot: PybulletRobot, opening: float, duration: float = 0.5) -> None:
    q, now_open = planning_joints(robot.target)
    rate = (opening - now_open) / duration
    for k in range(int(duration / 0.002) + 1):
        speed = rate if k < int(duration / 0.002) else 0.0
        position = robot_joints(q, now_open + rate * 0.002 * k)
        robot.servo_jp(Setpoint(position, robot_joints(np.zeros(9), speed), robot.now))
        robot.advance(robot.now + 0.002)
    robot.advance(robot.now + 0.05)


def on_the_tissue(**changes) -> PybulletRobot:
    """A robot whose tissue hangs with its grasp point at the home position of the tip."""
    with make() as robot:
        shift = robot.tip - np.array(CONFIG.scene.tissue.reference_point)
    tissue = replace(
        CONFIG.scene.tissue,
        centre=tuple(np.array(CONFIG.scene.tissue.centre) + shift),
        reference_point=tuple(np.array(CONFIG.scene.tissue.reference_point) + shift),
        **changes,
    )
    return PybulletRobot(replace(CONFIG, scene=replace(CONFIG.scene, tissue=tissue)))


def test_it_holds_against_gravity_from_the_first_step():
    with make() as robot:
        robot.advance(0.5)
        assert np.abs(robot.reading.position - HOME).max() < 1e-6
        assert np.abs(robot.reading.effort[1]) > 1.0
        assert robot.measured_js().fault == ""


def test_measurements_carry_all_ten_joints_and_the_time_of_the_last_step():
    with make(start=100.0) as robot:
        robot.advance(100.02)
        measured = robot.measured_js()
        assert measured.position.shape == (len(JOINTS),)
        assert measured.stamp == pytest.approx(100.02)
        assert not measured.gripped
        assert measured.tension == 0.0


def test_it_starts_at_its_own_start_position_and_stays_there():
    q = np.array(CONFIG.scene.home) + np.linspace(-0.2, 0.2, 9)
    with make(start_position=tuple(q)) as robot:
        robot.advance(0.2)
        begin = robot_joints(q, CONFIG.scene.home_opening)
        assert np.abs(robot.measured_js().position - begin).max() < 1e-6
        assert robot.fault == ""


def test_a_start_beyond_the_limits_of_a_joint_is_refused_by_its_name():
    q = np.array(CONFIG.scene.home)
    q[1] = 3.0
    with pytest.raises(ConfigError, match=r"joint_2 is 3\.0, allowed: -2\.24"):
        make(start_position=tuple(q))


def test_a_joint_that_the_arm_lacks_starts_at_zero_only():
    config = settings_of(SimulationConfig, ("limits", "scene", "simulator", "plant"))
    q = np.where(np.arange(9) == 6, 0.01, config.scene.home)  # within its limits
    start = replace(config.simulator, start_position=tuple(q.tolist()))
    with pytest.raises(ConfigError, match=r"joint_7 is 0\.01, allowed: 0, since the arm lacks it"):
        PybulletRobot(replace(config, simulator=start), URDF)


def test_it_follows_within_micrometres_and_within_torque_limits():
    with make() as robot:
        before = robot.now
        readings = swing(robot, 1.0, np.linspace(0.05, 0.1, 10))
        assert robot.now == pytest.approx(before + 1.0)
        assert np.abs(robot.reading.position - robot.target).max() < 5e-6
        assert all((np.abs(r.effort) <= TORQUE + 1e-9).all() for r in readings)
        assert robot.fault == ""


def test_measured_velocity_is_the_rate_of_the_measured_position():
    with make() as robot:
        readings = swing(robot, 0.5, np.full(10, 0.05))
        position = np.array([r.position for r in readings])
        velocity = np.array([r.velocity for r in readings])
        assert np.allclose(np.diff(position, axis=0) * 1000.0, velocity[1:], atol=1e-3)


def test_a_load_beyond_the_motors_is_a_named_fault_and_never_exceeds_their_torque():
    with make(tool_load=20.0) as robot:
        robot.push_load(np.array([0.0, 0.0, -200.0]))
        efforts = []
        robot.advance(0.5, lambda: efforts.append(np.abs(robot.reading.effort)))
        assert (np.array(efforts) <= TORQUE + 1e-9).all()
        assert "off its course" in robot.fault


def test_without_setpoints_after_motion_it_comes_to_rest_and_stays():
    with make() as robot:
        swing(robot, 0.3, np.full(10, 0.05))
        robot.advance(robot.now + 0.5)
        assert robot.servo_state is ServoState.HOLDING
        assert "stopped coming" in robot.fault
        rest = robot.reading.position
        robot.advance(robot.now + 0.5)
        assert np.abs(robot.reading.position - rest).max() < 1e-6


def test_a_fault_is_cleared_at_rest_and_motion_goes_on():
    with make() as robot:
        swing(robot, 0.3, np.full(10, 0.05))
        robot.advance(robot.now + 0.5)
        robot.clear_fault()
        assert robot.measured_js().fault == ""
        for _ in range(20):
            robot.servo_jp(Setpoint(robot.target, STILL, robot.now))
            robot.advance(robot.now + 0.002)
        assert robot.servo_state is ServoState.FOLLOWING


def test_jaws_that_close_on_tissue_hold_it_and_opening_lets_go():
    with on_the_tissue() as robot:
        turn_jaws(robot, 0.5)
        turn_jaws(robot, 0.0)
        assert robot.measured_js().gripped
        assert robot.measured_js().tension < 0.05
        turn_jaws(robot, 0.5)
        assert not robot.measured_js().gripped
        assert robot.measured_js().tension == 0.0


def test_jaws_that_were_never_open_hold_nothing():
    with on_the_tissue() as robot:
        robot.advance(0.2)
        assert not robot.measured_js().gripped


def test_what_the_tissue_does_to_the_jaws_the_joints_feel_to_the_last_newton_metre():
    model = load_robot()
    with on_the_tissue(stiffness=400.0) as robot:
        turn_jaws(robot, 0.5)
        turn_jaws(robot, 0.0)
        size = np.zeros(10)
        size[1] = -0.006
        swing(robot, np.pi / 4.0, size)
        robot.advance(robot.now + 1.0)
        force, pulled = robot.force, robot.reading.effort
        robot.tissue.reset()
        robot.advance(robot.now + 0.2)
        assert not robot.force.any()
        assert np.abs(robot.reading.position - robot.target).max() < 5e-6
        free = robot.reading.effort
        J = Configuration(model, planning_joints(robot.reading.position)[0]).J_tip
    assert np.linalg.norm(force) > 0.5
    assert np.allclose((pulled - free)[:8], -(J[:3].T @ force)[:8], atol=2e-3)


def digest_of_a_run() -> str:
    """Hash of all joint readings while tissue is taken and pulled, and of the force at the end."""
    with on_the_tissue() as robot:
        turn_jaws(robot, 0.5)
        turn_jaws(robot, 0.0)
        seen = hashlib.sha256()
        for reading in swing(robot, 0.3, np.full(10, 0.01)):
            for values in (reading.position, reading.velocity, reading.effort):
                seen.update(values.tobytes())
        assert robot.tissue.is_held
        seen.update(robot.force.tobytes())
        return seen.hexdigest()


def test_the_same_setpoints_give_the_same_bits_again_and_in_another_process():
    once = digest_of_a_run()
    assert digest_of_a_run() == once
    elsewhere = subprocess.run(
        [sys.executable, "-c", f"import {__name__} as t; print(t.digest_of_a_run())"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert once in elsewhere.stdout.split()


def test_two_newtons_at_the_tip_are_two_newtons_in_the_joints():
    load = np.array([0.0, 0.0, -2.0])
    with make() as robot:
        robot.advance(0.1)
        free, away = robot.reading.effort, []
        robot.push_load(load)
        robot.advance(0.3, lambda: away.append(np.abs(robot.reading.position - HOME).max()))
        J = Configuration(load_robot(), planning_joints(robot.reading.position)[0]).J_tip
        felt = np.linalg.lstsq(-J[:3, :8].T, (robot.reading.effort - free)[:8], rcond=None)[0]
        assert np.allclose(felt, load, atol=1e-3)
        assert max(away) < 1e-8
        robot.push_load(np.zeros(3))
        robot.advance(0.5)
        assert np.allclose(robot.reading.effort, free, atol=1e-6)


def test_time_is_skipped_only_at_rest():
    with make() as robot:
        robot.skip(1.0)
        assert robot.now == pytest.approx(1.0)
        swing(robot, 0.1, np.full(10, 0.05))
        with pytest.raises(RuntimeError, match="while the joints move"):
            robot.skip(1.0)


def test_a_model_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no\.urdf"):
        PybulletRobot(CONFIG, urdf=tmp_path / "no.urdf")


def test_links_of_the_tool_may_have_any_name(tmp_path):
    urdf = tmp_path / "renamed.urdf"
    urdf.write_text(renamed_urdf(), encoding="utf-8")
    with make() as robot, PybulletRobot(CONFIG, urdf=urdf) as renamed:
        for one in (robot, renamed):
            one.push_load(np.array([0.0, 0.5, -1.0]))
            one.advance(0.1)
        np.testing.assert_array_equal(renamed.tip, robot.tip)
        np.testing.assert_array_equal(renamed.shaft(), robot.shaft())
        np.testing.assert_array_equal(renamed.reading.effort, robot.reading.effort)
