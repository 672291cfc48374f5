# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import CONFIG_FOLDER, load_motion_config, load_simulation_config
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rcm import rcm_state
from typed_config import ConfigError


def test_the_shipped_settings_load():
    assert load_motion_config().controller.rate == 500.0
    assert load_simulation_config().simulator.physics_rate == 1000.0


def test_every_key_of_every_settings_file_has_a_unit_or_meaning_beside_it():
    for name in ("controller", "rcm", "scene"):
        for line in (CONFIG_FOLDER / f"{name}.yaml").read_text().splitlines():
            key, _, value = line.partition(":")
            if value.strip() and not key.startswith("#") and "home" not in key:
                assert "#" in line, f"{name}.yaml: {line}"


def test_at_home_the_shaft_goes_through_the_trocar(robot, motion_config, home):
    trocar = np.array(motion_config.scene.trocar)
    assert rcm_state(Configuration(robot, home), trocar).error < 1e-9


def test_cameras_of_one_picture_have_one_height():
    simulator = load_simulation_config().simulator
    lower = replace(simulator.endoscope, size=(400, 300))
    with pytest.raises(ConfigError, match=r"endoscope.size.*as high as overview.size"):
        replace(simulator, endoscope=lower)
