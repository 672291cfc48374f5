# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import CONFIG_FOLDER, EMPTY, load_motion_config, load_simulation_config
from rst_control.config.motion import MIN_OPEN
from rst_control.config.torque_tension import load_torque_tension
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


def changed_folder(tmp_path, file, line, changed):
    """The shipped settings with one line changed."""
    for name in ("limits", "rcm", "scene", "controller", "collision", "torque_tension"):
        text = (CONFIG_FOLDER / f"{name}.yaml").read_text()
        if f"{name}.yaml" == file:
            assert text.count(line) == 1
            text = text.replace(line, changed)
        (tmp_path / f"{name}.yaml").write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("file", "line", "changed", "words"),
    [
        (
            "controller.yaml",
            "\n  open: 0.6 ",
            "\n  open: 0.15 ",
            r"controller.yaml: jaws.open is 0.15, allowed: a number from 0.2 to 1.5 rad",
        ),
        (
            "limits.yaml",
            "\nfinger: 1.5707 ",
            "\nfinger: 0.3 ",
            r"limits.finger is 0.3, allowed: above 0.32 rad, half of controller.jaws.open "
            r"\(0.6 rad\) and limits.position_margin \(0.02 rad\)",
        ),
        (
            "limits.yaml",
            "\nposition_margin: 0.02 ",
            "\nposition_margin: 0.2 ",
            r"limits.yaml: pitch is 0.15, allowed: above position_margin, 0.2 rad",
        ),
    ],
)
def test_jaws_that_never_end_a_grasp_and_a_tool_without_room_are_refused(
    tmp_path, file, line, changed, words
):
    folder = changed_folder(tmp_path, file, line, changed)
    if "pitch" in words:
        limits = folder / "limits.yaml"
        limits.write_text(limits.read_text().replace("\npitch: 1.5 ", "\npitch: 0.15 "))
    with pytest.raises(ConfigError, match=words):
        load_motion_config(folder)


def test_a_tare_waits_for_no_more_than_all_jaws_open(tmp_path):
    file = "torque_tension.yaml"
    folder = changed_folder(tmp_path, file, "\n  opening: 0.15 ", "\n  opening: 0.3 ")
    with pytest.raises(ConfigError, match=r"tare.opening is 0.3, allowed: a number from 0 to 0.15"):
        load_torque_tension(folder / file)
    assert load_torque_tension().tare.opening <= EMPTY < MIN_OPEN
