# SPDX-License-Identifier: BSD-3-Clause
"""Set-up builds our stand-ins for other people's messages only where those are not found."""

import os
import subprocess
from pathlib import Path

import pytest

SETUP = Path(__file__).resolve().parents[2] / "docker" / "setup.sh"
STAND_INS = [
    "audio_common_msgs",
    "control_msgs",
    "crtk_msgs",
    "kortex_driver",
    "openrst_control",
    "speech_recognition_msgs",
]


def elsewhere(*spaces):
    """Packages that set-up would leave out upon these devel or install spaces."""
    environment = {**os.environ, "UNDERLAY": ":".join(map(str, spaces))}
    output = subprocess.run(
        [str(SETUP), "elsewhere"], env=environment, capture_output=True, text=True, check=True
    ).stdout
    return [name for name in output.strip().split(";") if name]


@pytest.fixture
def space(tmp_path):
    """Makes a devel space that provides packages."""

    def make(name, *packages):
        for package in packages:
            folder = tmp_path / name / "share" / package / "cmake"
            folder.mkdir(parents=True)
            (folder / f"{package}Config.cmake").touch()
        return tmp_path / name

    return make


def installed():
    """What the system itself has, on any machine."""
    return [
        name for name in STAND_INS if Path(f"/usr/share/{name}/cmake/{name}Config.cmake").exists()
    ]


def test_without_other_workspaces_all_are_built_that_the_system_lacks():
    assert elsewhere() == installed()


@pytest.mark.parametrize("package", STAND_INS)
def test_what_another_workspace_provides_is_not_built(space, package):
    assert elsewhere(space("other", package)) == sorted({*installed(), package})


def test_several_workspaces_count_together_and_each_package_once(space):
    first, second = space("a", "control_msgs"), space("b", "control_msgs", "kortex_driver")
    assert elsewhere(first, second)[:2] == ["control_msgs", "kortex_driver"]


def test_other_packages_of_a_workspace_change_nothing(space):
    assert elsewhere(space("other", "trajectory_msgs", "control_toolbox")) == installed()


def test_a_path_that_depends_on_where_it_is_read_is_refused():
    done = subprocess.run(
        [str(SETUP), "workspace"],
        env={**os.environ, "UNDERLAY": "catkin_ws/devel"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "UNDERLAY names catkin_ws/devel, allowed: absolute paths" in done.stderr


def test_a_folder_that_is_no_catkin_space_is_refused(tmp_path):
    environment = {**os.environ, "UNDERLAY": str(tmp_path)}
    done = subprocess.run(
        [str(SETUP), "workspace"], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "no .catkin" in done.stderr
