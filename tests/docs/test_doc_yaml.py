# SPDX-License-Identifier: BSD-3-Clause
"""The examples of docs/how-to/another-robot.md: a new tool."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from rst_control.config import CONFIG_FOLDER, load_motion_config
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rcm import rcm_state
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.planner import Planner

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "how-to" / "another-robot.md").read_text(encoding="utf-8")
BLOCK = r"<!-- {marker} -->\n```\w*\n(.*?)```"


def block(marker: str) -> str:
    """The fenced text behind a marker, of which there has to be one."""
    found = re.findall(BLOCK.format(marker=re.escape(marker)), PAGE, re.DOTALL)
    assert len(found) == 1, f"{len(found)} blocks marked {marker!r}"
    return str(found[0])


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    """The robot that the commands of the page make of its numbers, with the row of the page."""
    folder = tmp_path_factory.mktemp("tool")
    numbers = yaml.safe_load((CONFIG_FOLDER / "gen3_openrst.yaml").read_text(encoding="utf-8"))
    for name, changes in yaml.safe_load(block("example: tool")).items():
        (row,) = [joint for joint in numbers["joints"] if joint["name"] == name]
        row.update(changes)
    (folder / "long_shaft.yaml").write_text(yaml.safe_dump(numbers), encoding="utf-8")
    for line in block("run: unit").splitlines():
        program, *arguments = shlex.split(line)
        assert program == "python"
        words = [sys.executable, *arguments]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    return load_robot(folder / "long_shaft.urdf")


def test_another_tool_is_made_by_the_commands_of_the_page(robot):
    assert robot.shaft_length == pytest.approx(0.36)


def test_the_longer_shaft_is_planned_through_the_trocar(robot):
    planner = Planner(robot, load_motion_config())
    at_grasp = planner.solver.search(planner.grasp_candidates[0].T_base_tip, planner.trocar)
    assert at_grasp.is_solved
    pull = planner.leg(at_grasp.q, _lifted(planner.grasp_candidates[0].T_base_tip))
    for s in np.linspace(0.0, pull.length, 20):
        here = Configuration(robot, pull.evaluate(s).q)
        assert rcm_state(here, planner.trocar).error < 1e-6
        assert rcm_state(here, planner.trocar).insertion < 0.36


def _lifted(pose):
    goal = pose.copy()
    goal[2, 3] += 0.01
    return goal
