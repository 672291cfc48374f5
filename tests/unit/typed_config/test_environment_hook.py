# SPDX-License-Identifier: BSD-3-Clause
"""What a shell gets that sources the workspace, for an account with a home and for one without."""

import stat
import subprocess
from pathlib import Path

HOOK = Path(__file__).resolve().parents[3] / "catkin_ws/src/typed_config/env-hooks"
NOWHERE = "/proc/self/nowhere"  # where nobody can write, root included


def sourced(**environment):
    """The folder of ROS's files after sourcing, once and once more."""
    line = 'set -e; . "$1"; . "$1"; printf %s "${ROS_HOME-unset}"'
    given = {"PATH": "/usr/bin:/bin", **environment}
    words = ["/bin/sh", "-c", line, "sh", str(HOOK / "10.environment.sh.in")]
    return subprocess.run(words, env=given, capture_output=True, text=True, check=True).stdout


def test_an_account_with_a_home_keeps_its_logs_there(tmp_path):
    assert sourced(HOME=str(tmp_path)) == "unset"
    assert (tmp_path / ".ros").is_dir()


def test_an_account_without_a_home_gets_a_folder_that_is_its_own(tmp_path):
    for home in ({"HOME": NOWHERE}, {}):
        folder = Path(sourced(TMPDIR=str(tmp_path), **home))
        assert folder.parent == tmp_path
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_a_folder_that_is_named_stays(tmp_path):
    assert sourced(HOME=NOWHERE, ROS_HOME=str(tmp_path)) == str(tmp_path)


def test_nothing_is_set_where_nothing_can_be_written():
    assert sourced(HOME=NOWHERE, TMPDIR=NOWHERE) == "unset"
