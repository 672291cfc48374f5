# SPDX-License-Identifier: BSD-3-Clause
"""Fixtures of the tests of motion: the robot, its settings and its planner, made once."""

import numpy as np
import pytest

from rst_control.commands.verifier import Verifier
from rst_control.config import load_motion_config
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.insertion import Insertion
from rst_control.planning.planner import Planner


@pytest.fixture(scope="session")
def robot():
    return load_robot()


@pytest.fixture(scope="session")
def motion_config():
    return load_motion_config()


@pytest.fixture(scope="session")
def planner(robot, motion_config):
    return Planner(robot, motion_config)


@pytest.fixture(scope="session")
def home(motion_config):
    return np.array(motion_config.scene.home)


@pytest.fixture(scope="session")
def verify(planner):
    return Verifier(planner)


@pytest.fixture(scope="session")
def gate(planner, home):
    """Joints outside the trocar where an insertion begins and a withdrawal ends."""
    return Insertion(planner).withdraw(home)[-1].path.end


@pytest.fixture
def joints(home):
    """At home, the jaws open."""
    return robot_joints(home, 0.0)
