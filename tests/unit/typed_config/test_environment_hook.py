# SPDX-License-Identifier: BSD-3-Clause
"""What a shell gets that sources the workspace, for an account with a home and for one without."""

import os
import shutil
import stat
import subprocess
import tempfile
from pathlib import Path

import pytest

HOOK = Path(__file__).resolve().parents[3] / "catkin_ws/src/typed_config/env-hooks"
NOWHERE = "/proc/self/nowhere"  # where nobody can write, root included


NOBODY = 65534
BECOME = ("setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups")


def sourced(*become, hook=HOOK / "10.environment.sh.in", shown="ROS_HOME", **environment):
    """A variable after sourcing once and once more: the folder of ROS's files, if none is named."""
    line = f'set -e; . "$1"; . "$1"; printf %s "${{{shown}-unset}}"'
    given = {"PATH": "/usr/bin:/bin", **environment}
    words = [*become, "/bin/sh", "-c", line, "sh", str(hook)]
    return subprocess.run(words, env=given, capture_output=True, text=True, check=True).stdout


@pytest.fixture
def account():
    """Sources as an account without rights, with a home and a TMPDIR of its own; both are given."""
    is_root = os.geteuid() == 0
    if is_root and not shutil.which("setpriv"):
        pytest.skip("setpriv is missing: root can write everywhere, and cannot become nobody")
    with tempfile.TemporaryDirectory() as name:  # pytest's own folder is closed to others
        top = Path(name)
        top.chmod(0o755)
        hook = shutil.copy(HOOK / "10.environment.sh.in", top)
        home, temporary = top / "home", top / "temporary"
        for folder in (home, temporary):
            folder.mkdir()
            if is_root:
                os.chown(folder, NOBODY, NOBODY)
        become = BECOME if is_root else ()
        yield home, lambda: sourced(*become, hook=hook, HOME=str(home), TMPDIR=str(temporary))


def test_an_account_with_a_home_keeps_its_logs_there(tmp_path):
    assert sourced(HOME=str(tmp_path)) == "unset"
    assert (tmp_path / ".ros").is_dir()


def test_so_does_an_account_without_rights(account):
    home, source = account
    assert source() == "unset"
    assert (home / ".ros" / "log").is_dir()


@pytest.mark.parametrize("closed", [".ros", ".ros/log"])
def test_logs_go_elsewhere_where_somebody_else_owns_the_folder(account, closed):
    """As root does after one `sudo -E roslaunch`."""
    home, source = account
    for folder in (home / ".ros", home / ".ros" / "log"):
        folder.mkdir()
        folder.chmod(0o777)
    (home / closed).chmod(0o555)
    found = source()
    assert Path(found).parent == home.with_name("temporary")
    assert stat.S_IMODE(Path(found).stat().st_mode) == 0o700


def test_logs_go_elsewhere_where_no_folder_for_them_can_be_made(tmp_path):
    (tmp_path / ".ros").symlink_to("/proc/self")
    assert Path(sourced(HOME=str(tmp_path), TMPDIR=str(tmp_path))).parent == tmp_path


def test_an_account_without_a_home_gets_a_folder_that_is_its_own(tmp_path):
    for home in ({"HOME": NOWHERE}, {}):
        folder = Path(sourced(TMPDIR=str(tmp_path), **home))
        assert folder.parent == tmp_path
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_a_folder_that_is_named_stays(tmp_path):
    assert sourced(HOME=NOWHERE, ROS_HOME=str(tmp_path)) == str(tmp_path)


def test_nothing_is_set_where_nothing_can_be_written():
    assert sourced(HOME=NOWHERE, TMPDIR=NOWHERE) == "unset"


@pytest.mark.parametrize(("before", "after"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "4"}, "4")])
def test_numpy_keeps_to_one_core_where_nobody_says_otherwise(tmp_path, before, after):
    found = sourced(shown="OPENBLAS_NUM_THREADS", HOME=str(tmp_path), **before)
    assert found == after
