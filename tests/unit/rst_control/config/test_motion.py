# SPDX-License-Identifier: BSD-3-Clause
import shutil
from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import CONFIG_FOLDER, load_motion_config, load_simulation_config
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rcm import rcm_state
from typed_config import ConfigError


@pytest.fixture
def folder(tmp_path):
    for file in CONFIG_FOLDER.glob("*.yaml"):
        shutil.copy(file, tmp_path)
    return tmp_path


def test_the_shipped_settings_load():
    assert load_motion_config().controller.rate == 500.0
    assert load_simulation_config().simulator.physics_rate == 1000.0


def test_a_misspelt_key_is_refused_and_the_right_one_named(folder):
    file = folder / "controller.yaml"
    file.write_text(file.read_text().replace("  tip_speed:", "  tip_sped:"))
    with pytest.raises(ConfigError, match=r"controller\.yaml.*tip_sped.*did you mean tip_speed"):
        load_motion_config(folder)


def test_a_value_out_of_range_is_refused_with_its_file_and_unit(folder):
    file = folder / "rcm.yaml"
    file.write_text(file.read_text().replace("knot_spacing: 0.0015", "knot_spacing: 0.5"))
    with pytest.raises(ConfigError, match=r"rcm\.yaml: knot_spacing is 0\.5, allowed.* m$"):
        load_motion_config(folder)


@pytest.mark.parametrize("trocar", ["[0.4, 0.0]", "[.nan, 0.0, 0.4]", "[0.4, 0.0, 41.5]", "here"])
def test_a_trocar_that_is_no_point_is_refused_with_its_key_and_what_is_allowed(folder, trocar):
    file = folder / "scene.yaml"
    file.write_text(file.read_text().replace("[0.406, -0.024, 0.415] ", f"{trocar} ", 1))
    with pytest.raises(ConfigError, match=r"scene\.yaml: trocar.* allowed: .*-2 to 2 m"):
        load_motion_config(folder)


def test_a_trocar_may_not_be_set_further_off_than_motion_bears(folder):
    file = folder / "rcm.yaml"
    file.write_text(file.read_text().replace("  tolerance: 1.0e-3 ", "  tolerance: 1.1e-3 "))
    with pytest.raises(ConfigError, match=r"registration\.tolerance is 0\.0011.* 0\.001$"):
        load_motion_config(folder)


def test_a_missing_key_is_refused(folder):
    file = folder / "limits.yaml"
    file.write_text(file.read_text().replace("position_margin", "#"))
    with pytest.raises(ConfigError, match="position_margin is missing"):
        load_motion_config(folder)


def test_every_key_of_every_settings_file_has_a_unit_or_meaning_beside_it():
    for name in ("controller", "rcm", "scene"):
        for line in (CONFIG_FOLDER / f"{name}.yaml").read_text().splitlines():
            key, _, value = line.partition(":")
            if value.strip() and not key.startswith("#") and "home" not in key:
                assert "#" in line, f"{name}.yaml: {line}"


def test_at_home_the_shaft_goes_through_the_trocar(robot, motion_config, home):
    trocar = np.array(motion_config.scene.trocar)
    assert rcm_state(Configuration(robot, home), trocar).error < 1e-9


def test_the_tension_settings_leave_room_below_the_limit(motion_config):
    tension = motion_config.controller.tension
    assert tension.minimum < tension.initial < tension.maximum < tension.limit


@pytest.mark.parametrize(
    ("changes", "named"), [({"limit": 2.0}, "maximum"), ({"maximum": 0.9}, "initial")]
)
def test_a_pull_that_could_never_arrive_is_refused_at_the_start(changes, named):
    tension = load_motion_config().controller.tension
    with pytest.raises(ConfigError, match=named):
        replace(tension, **changes)


def test_cameras_of_one_picture_have_one_height():
    simulator = load_simulation_config().simulator
    lower = replace(simulator.endoscope, size=(400, 300))
    with pytest.raises(ConfigError, match=r"endoscope.size.*as high as overview.size"):
        replace(simulator, endoscope=lower)
