# SPDX-License-Identifier: BSD-3-Clause
"""What the launch files start stays on loopback, unless the environment says otherwise."""

from pathlib import Path

import pytest
from roslaunch.config import load_config_default
from roslaunch.core import RLException

from tests.support.launch_reading import read

LAUNCH = Path(__file__).resolve().parents[2] / "launch"
FILES = sorted(LAUNCH.glob("*.launch"))
LIMITS = LAUNCH.parent / "catkin_ws/src/rst_control/config/kinova_limits.yaml"
TROCAR = ["trocar_x:=0.406", "trocar_y:=-0.024", "trocar_z:=0.415"]
ASKED = {"kinova": [*TROCAR, f"limits:={LIMITS}", "simulate:=true"]}  # what has no default


@pytest.mark.parametrize("name", ["system", "kinova"])  # that all ask for it: test_launch_line.py
def test_without_an_address_no_file_is_launched(name, monkeypatch):
    for variable in ("ROS_IP", "ROS_HOSTNAME"):
        monkeypatch.delenv(variable, raising=False)
    words = [(str(LAUNCH / f"{name}.launch"), ASKED.get(name, []))]
    with pytest.raises(RLException, match="Cannot load command parameter"):
        load_config_default(words, None, verbose=False)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_node_gets_the_address_of_the_shell(file, monkeypatch):
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    found = read([str(file), *ASKED.get(file.stem, [])]).nodes
    assert found
    for name, node in found.items():
        assert node.environment["ROS_IP"] == "127.0.0.1", name


def test_who_sets_an_address_gets_it(monkeypatch):
    monkeypatch.setenv("ROS_IP", "10.7.0.2")
    for name, node in read([str(LAUNCH / "system.launch")]).nodes.items():
        assert node.environment["ROS_IP"] == "10.7.0.2", name
