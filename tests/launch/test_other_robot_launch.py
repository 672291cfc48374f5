# SPDX-License-Identifier: BSD-3-Clause
"""The launch line of docs/how-to/another-robot.md gives the controller the other robot, whole."""

import re
import shlex
from pathlib import Path

import numpy as np
from roslaunch.config import load_config_default

from rst_control.config import MotionConfig
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rcm import rcm_state
from rst_control.kinematics.robot_model import parse_robot
from rst_control.planning.planner import Planner
from typed_config import load_config

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "how-to" / "another-robot.md").read_text(encoding="utf-8")


def parameters(line, monkeypatch):
    """The parameter server's contents after a `roslaunch file name:=value ...`, nested."""
    monkeypatch.chdir(ROOT)
    _, file, *arguments = shlex.split(line)
    loaded = load_config_default([(file, arguments)], None, verbose=False).params
    tree = {}
    for name, parameter in loaded.items():
        branch, *path = tree, *name.strip("/").split("/")
        for part in path[:-1]:
            branch = branch.setdefault(part, {})
        branch[path[-1]] = parameter.value
    return tree


def test_the_controller_gets_settings_and_model_of_the_six_joint_arm(monkeypatch):
    (line,) = re.findall(r"^roslaunch launch/controller\.launch .*urdf.*$", PAGE, re.MULTILINE)
    given = parameters(line, monkeypatch)
    config = load_config(MotionConfig, given["controller"], "controller parameters")
    planner = Planner(parse_robot(given["robot_description"]), config)
    assert planner.model.locked == (6,)
    home = Configuration(planner.model, config.scene.home)
    assert rcm_state(home, planner.trocar).error < 1e-9
    path = planner.reach(np.array(config.scene.home))[-1]
    assert path.sample(planner.model.chain, planner.trocar).rcm_error.max() < 1e-6
