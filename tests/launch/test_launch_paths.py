# SPDX-License-Identifier: BSD-3-Clause
"""Settings files may lie in a folder with a space and an apostrophe in its name."""

import shutil

import pytest
from roslaunch.config import load_config_default

from tests.launch.test_launch_loopback import LAUNCH, LIMITS, TROCAR

VOICE = LAUNCH.parent / "catkin_ws/src/voice_assist/config"


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "the surgeon's own"


def parameters(file, *arguments):
    found = load_config_default([(str(LAUNCH / file), list(arguments))], None, verbose=False)
    return {name: parameter.value for name, parameter in found.params.items()}


def test_the_system_reads_them(folder):
    shutil.copytree(VOICE, folder)
    overrides = folder / "overrides.yaml"
    overrides.write_text("{controller: {speed: {scale: 0.25}}}\n", "utf-8")
    found = parameters("system.launch", f"config:={folder}", f"controller_overrides:={overrides}")
    assert found["/controller/controller/speed/scale"] == 0.25
    assert found["/checked_settings/voice"].startswith("8 files")


def test_the_system_on_the_real_arm_reads_them(folder):
    folder.mkdir()
    limits, scene = (shutil.copy(LIMITS.with_name(n), folder) for n in (LIMITS.name, "scene.yaml"))
    found = parameters(
        "kinova.launch", *TROCAR, f"limits:={limits}", f"scene:={scene}", "simulate:=true"
    )
    assert found["/kinova_preflight"] and found["/checked_settings/kinova"].startswith("7 files")
