# SPDX-License-Identifier: BSD-3-Clause
"""The simulated robot is the one of its URDF: an arm of six joints stands, and holds, as well."""

from pathlib import Path

import numpy as np

from rst_control.config import CONFIG_FOLDER, SimulationConfig
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.robot_model import load_robot
from rst_control.simulation.pybullet_robot import PybulletRobot
from typed_config import load_config, load_yaml, overlaid

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "ur5e_openrst"
SECTIONS = ("limits", "scene", "simulator", "plant")


def test_an_arm_of_six_joints_is_simulated_from_its_own_urdf():
    own = load_yaml(FOLDER / "settings.yaml")
    data = {name: load_yaml(CONFIG_FOLDER / f"{name}.yaml") for name in SECTIONS}
    data = overlaid(data, {name: own[name] for name in SECTIONS if name in own})
    config = load_config(SimulationConfig, data)
    urdf = FOLDER / "robot.urdf"
    home = Configuration(load_robot(urdf), np.array(config.scene.home))
    with PybulletRobot(config, urdf) as robot:
        robot.advance(until=0.5)
        assert not robot.fault
        np.testing.assert_allclose(robot.reading.position[:9], config.scene.home, atol=1e-6)
        assert robot.reading.position[6] == 0.0
        first, last = robot.shaft()
    np.testing.assert_allclose(first, home.frames[forward.SHAFT, :, 3], atol=1e-6)
    np.testing.assert_allclose(last, home.frames[forward.PITCH, :, 3], atol=1e-6)
