# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import CONFIG_FOLDER, LimitsConfig
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinova.config import load_kinova_config
from rst_control.planning.planner import Planner
from tests.support.changed_settings import changed
from typed_config import load_config, load_yaml

LIMITS = load_config(LimitsConfig, load_yaml(CONFIG_FOLDER / "kinova_limits.yaml"))


@pytest.fixture(scope="session")
def kinova():
    return replace(load_kinova_config(), limits=LIMITS)


@pytest.fixture(scope="session")
def soft_planner(robot, motion_config):
    """Plans within what the driver allows."""
    return Planner(robot, replace(changed(motion_config, jaws={"braking": 6.0}), limits=LIMITS))


@pytest.fixture
def hardware(kinova, motion_config):
    from tests.unit.rst_control.kinova.fake_hardware import FakeHardware

    made = FakeHardware(robot_joints(np.array(motion_config.scene.home), 0.6))
    made.ready(kinova)
    return made


@pytest.fixture
def way(soft_planner, home, hardware):
    from tests.unit.rst_control.kinova.fake_hardware import Way

    return Way(soft_planner, home, hardware.now + 0.5)
