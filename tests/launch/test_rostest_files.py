# SPDX-License-Identifier: BSD-3-Clause
"""`rostest rst_control NAME.test` and `catkin_make run_tests` find each file and its scripts."""

from pathlib import Path
from xml.etree import ElementTree

import pytest
import roslib.packages
import rospkg

FILES = sorted((Path(__file__).resolve().parents[1] / "rostest").rglob("*.test"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_each_file_and_its_scripts_are_found_by_their_names_alone(file):
    (found,) = roslib.packages.find_resource("rst_control", file.name)
    assert Path(found).samefile(file)
    assert rospkg.get_package_name(found) == "rst_control"
    for test in ElementTree.parse(file).getroot().iter("test"):
        assert len(roslib.packages.find_node("rst_control", test.get("type"))) == 1


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_each_file_finds_what_its_scripts_import_and_its_launch_files(file):
    """By the package: its folder is a link, and roslaunch goes up from the link's own place."""
    root = ElementTree.parse(file).getroot()
    (path,) = (env.get("value") for env in root.iter("env") if env.get("name") == "PYTHONPATH")
    assert path.startswith("$(find rst_control)/../../..:")
    assert all(i.get("file").startswith("$(find rst_control)/") for i in root.iter("include"))
