# SPDX-License-Identifier: BSD-3-Clause
"""Gravity by the setting and by the root of the URDF, and a simulated arm that obeys both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import URDF_FILE, load_simulation_config
from rst_control.errors import RobotModelError
from rst_control.kinematics.inverse_dynamics import InverseDynamics
from rst_control.kinematics.mounting import gravity_in_base
from rst_control.kinematics.robot_model import parse_robot
from rst_control.simulation.pybullet_robot import PybulletRobot

TEXT = URDF_FILE.read_text(encoding="utf-8")
CONFIG = load_simulation_config()


def turned(rpy: str) -> str:
    """The same robot with its base turned against the root, and beside it."""
    parent, child = '<parent link="world" />', '<child link="base_link" />'
    start = TEXT.index("<joint")
    end = TEXT.index("</joint>", start)
    joint = TEXT[start:end]
    assert parent in joint and child in joint
    return TEXT.replace(joint, joint.replace('rpy="0 0 0"', f'rpy="{rpy}"'), 1)


def test_an_upright_arm_has_gravity_along_minus_z_unless_it_is_set() -> None:
    model = parse_robot(TEXT)
    np.testing.assert_allclose(gravity_in_base(model), [0.0, 0.0, -9.81])
    np.testing.assert_allclose(gravity_in_base(model, (2.0, 0.0, 0.0)), [9.81, 0.0, 0.0])


def test_the_root_of_the_urdf_is_obeyed_and_a_setting_that_differs_is_refused() -> None:
    model = parse_robot(turned("0 1.5707963267948966 0"))  # on a wall: z of the base along x
    np.testing.assert_allclose(gravity_in_base(model), [9.81, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(gravity_in_base(model, (1.0, 0.0, 0.0)), [9.81, 0.0, 0.0])
    with pytest.raises(RobotModelError, match=r"\[0.000, 0.000, -1.000\].*90.0 deg.*1 deg"):
        gravity_in_base(model, (0.0, 0.0, -1.0))


@pytest.mark.parametrize("by_urdf", [True, False], ids=["by the URDF", "by the setting"])
def test_a_simulated_arm_on_a_wall_has_the_torques_of_a_wall_and_its_tip_in_the_base(
    by_urdf: bool, tmp_path
) -> None:
    text, config = TEXT, CONFIG
    if by_urdf:
        text = turned("0 1.5707963267948966 0")
    else:
        config = replace(CONFIG, scene=replace(CONFIG.scene, gravity=(1.0, 0.0, 0.0)))
    file = tmp_path / "robot.urdf"
    file.write_text(text, encoding="utf-8")
    with PybulletRobot(CONFIG) as upright, PybulletRobot(config, file) as robot:
        robot.advance(0.1)
        home = np.array(CONFIG.scene.home)
        asked = InverseDynamics(text, 0.0, np.array([9.81, 0.0, 0.0]))(home)
        np.testing.assert_allclose(robot.reading.effort[:7], asked, atol=0.02)
        np.testing.assert_allclose(robot.tip, upright.tip, atol=1e-6)
        np.testing.assert_allclose(robot.shaft(), upright.shaft(), atol=1e-6)
