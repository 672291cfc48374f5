# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import pytest

from rst_control.config import (
    CONFIG_FOLDER,
    EMPTY,
    MotionConfig,
    load_motion_config,
    load_simulation_config,
)
from rst_control.config.motion import MIN_OPEN
from rst_control.config.torque_tension import load_torque_tension
from typed_config import ConfigError, load_config, load_yaml, overlaid

SECTIONS = ("limits", "rcm", "scene", "controller", "collision")


def test_every_key_of_every_settings_file_has_a_unit_or_meaning_beside_it():
    for name in ("controller", "rcm", "scene"):
        for line in (CONFIG_FOLDER / f"{name}.yaml").read_text().splitlines():
            key, _, value = line.partition(":")
            if value.strip() and not key.startswith("#") and "home" not in key:
                assert "#" in line, f"{name}.yaml: {line}"


def test_cameras_of_one_picture_have_one_height():
    simulator = load_simulation_config().simulator
    lower = replace(simulator.endoscope, size=(400, 300))
    with pytest.raises(ConfigError, match=r"endoscope.size.*as high as overview.size"):
        replace(simulator, endoscope=lower)


def changed_folder(tmp_path, file, line, changed):
    """The shipped settings with one line changed."""
    for name in (*SECTIONS, "torque_tension"):
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


def with_jaws(config, layer, scale=1.0, **jaws):
    """Settings with other limits of the active layer, another scale and other jaws."""
    limits, controller = config.limits, config.controller
    layers = (replace(limits.active, **layer), *limits.layers[1:])
    speed, jaws = replace(controller.speed, scale=scale), replace(controller.jaws, **jaws)
    return replace(
        config,
        limits=replace(limits, layers=layers),
        controller=replace(controller, speed=speed, jaws=jaws),
    )


@pytest.mark.parametrize(
    ("layer", "jaws", "words"),
    [
        (
            {"tool_velocity": 0.05, "tool_acceleration": 0.1},
            {"speed": 3.0, "acceleration": 20.0},
            r"controller.jaws.speed is 3.0, allowed: up to 0.1 rad/s, twice tool_velocity of "
            r"limits.layers \(hard: 0.05 rad/s\) over controller.speed.scale \(1\)",
        ),
        (
            {"tool_acceleration": 0.1},
            {"acceleration": 20.0},
            r"controller.jaws.acceleration is 20.0, allowed: up to 0.2 rad/s\^2, twice "
            r"tool_acceleration of limits.layers \(hard: 0.1 rad/s\^2\)",
        ),
        (
            {"tool_acceleration": 3.0},
            {},
            r"controller.jaws.braking is 10.0, allowed: up to 6 rad/s\^2, twice tool_acceleration",
        ),
    ],
)
def test_jaws_that_pass_the_limits_of_the_tool_are_refused(motion_config, layer, jaws, words):
    with pytest.raises(ConfigError, match=words):
        with_jaws(motion_config, layer, **jaws)


def test_a_scaled_speed_of_the_jaws_may_be_as_high_as_the_limits_of_the_tool(motion_config):
    slow = {"tool_velocity": 0.15}
    assert with_jaws(motion_config, slow, scale=0.1, speed=3.0).controller.jaws.speed == 3.0
    with pytest.raises(ConfigError, match=r"controller\.jaws\.speed"):
        with_jaws(motion_config, slow, scale=0.11, speed=3.0)


@pytest.mark.parametrize("scale", [0.1, 1.0])
def test_the_shipped_settings_of_the_kinova_fit_each_other(scale):
    files = {name: load_yaml(CONFIG_FOLDER / f"{name}.yaml") for name in SECTIONS}
    files["limits"] = load_yaml(CONFIG_FOLDER / "kinova_limits.yaml")
    over = load_yaml(CONFIG_FOLDER / "kinova_controller.yaml")
    scaled = overlaid(over, {"controller": {"speed": {"scale": scale}}})
    config = load_config(MotionConfig, overlaid(files, scaled), "kinova settings")
    assert 0.5 * config.controller.jaws.braking <= config.limits.active.tool_acceleration == 3.0
    with pytest.raises(ConfigError, match=r"controller.jaws.braking is 10.0"):
        load_config(MotionConfig, files, "kinova_limits.yaml without kinova_controller.yaml")


def test_a_tare_waits_for_no_more_than_all_jaws_open(tmp_path):
    file = "torque_tension.yaml"
    folder = changed_folder(tmp_path, file, "\n  opening: 0.15 ", "\n  opening: 0.3 ")
    with pytest.raises(ConfigError, match=r"tare.opening is 0.3, allowed: a number from 0 to 0.15"):
        load_torque_tension(folder / file)
    assert load_torque_tension().tare.opening <= EMPTY < MIN_OPEN
