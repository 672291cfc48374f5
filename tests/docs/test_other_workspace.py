# SPDX-License-Identifier: BSD-3-Clause
"""The packages build in any catkin workspace, copied or linked; real packages replace stand-ins."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[2] / "catkin_ws" / "src"
PACKAGES = sorted(path.parent for path in SOURCES.glob("*/package.xml"))
# Python of the messages alone, of a package that is copied and of one that is linked
TARGETS = ("crtk_msgs_generate_messages_py", "voice_assist_generate_messages_py")

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]


def bare(**environment):
    fixed = {"HOME": os.environ["HOME"], "PATH": "/usr/bin:/bin", "LANG": "C.UTF-8"}
    return {**fixed, "ROS_LANG_DISABLE": "gencpp:genlisp", **environment}  # those are minutes


def catkin_make(workspace, *words, **environment):
    done = subprocess.run(
        ["catkin_make", "-j1", *words],
        cwd=workspace,
        env=bare(**environment),
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, " ".join((done.stdout + done.stderr).split())


@pytest.fixture
def workspace(tmp_path):
    """With half of the packages copied, and the others linked: one build shows both."""
    (tmp_path / "ws" / "src").mkdir(parents=True)
    for package in PACKAGES:
        to = tmp_path / "ws" / "src" / package.name
        if package.name < "s":
            compiled = shutil.ignore_patterns("__pycache__")  # others write there meanwhile
            shutil.copytree(package, to, symlinks=True, ignore=compiled)
        else:
            to.symlink_to(package)
    return tmp_path / "ws"


@pytest.fixture
def real(tmp_path):
    """A devel space of another workspace, with packages whose stand-ins we carry."""
    for name in ("control_msgs", "kortex_driver"):
        folder = tmp_path / "real" / "share" / name / "cmake"
        folder.mkdir(parents=True)
        (folder / f"{name}Config.cmake").touch()
    (tmp_path / "real" / ".catkin").touch()
    return tmp_path / "real"


def test_they_build_there_with_the_documented_line(workspace, real):
    python = f"-DPYTHON_EXECUTABLE={sys.prefix}/bin/python"
    status, printed = catkin_make(workspace, python, *TARGETS, CMAKE_PREFIX_PATH=str(real))
    assert status == 0, printed[-4000:]
    for name in ("control_msgs", "kortex_driver"):
        assert f"{name}: the one of {real} is taken, not the stand-in" in printed
        assert not (workspace / "devel" / "share" / name / "cmake").exists()
    assert (workspace / "devel/share/openrst_control/cmake/openrst_controlConfig.cmake").is_file()
    code = "import sys, crtk_msgs.msg, rst_control.kernels, voice_assist.srv; print(sys.prefix)"
    line = f'. {workspace}/devel/setup.sh; python3 -c "{code}"; rospack find voice_assist'
    words = ["/bin/sh", "-c", line]
    shown = subprocess.run(words, env=bare(), capture_output=True, text=True, check=True).stdout
    assert shown.split() == [sys.prefix, str(workspace / "src" / "voice_assist")]


def test_without_that_line_the_python_is_named_before_anything_is_built(tmp_path):
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "typed_config").symlink_to(SOURCES / "typed_config")
    status, printed = catkin_make(tmp_path, "-DPYTHON_EXECUTABLE=/usr/bin/python3")
    assert status != 0
    assert "-DPYTHON_EXECUTABLE=<checkout of voice_assist>/.venv/bin/python" in printed


def test_no_link_leads_out_of_the_packages():
    """But for those tests that `rostest` finds by one, which a copy of the packages lacks."""
    links = {path for path in SOURCES.rglob("*") if path.is_symlink()}
    out = {path.name for path in links if not path.resolve().is_relative_to(SOURCES)}
    assert out <= {"rostest", "CMakeLists.txt"}


def test_each_package_has_the_licence_of_the_repository():
    licence = (SOURCES.parents[1] / "LICENSE").read_bytes()
    assert all((package / "LICENSE").read_bytes() == licence for package in PACKAGES)
