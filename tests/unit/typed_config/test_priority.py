# SPDX-License-Identifier: BSD-3-Clause
"""A node's priority is that of its session too, as Linux weighs sessions first."""

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from typed_config import priority

SET = """
import os
from pathlib import Path
from typed_config.priority import set_priority
words = set_priority(19)
group = Path("/proc/self/autogroup")
print(words, os.getpriority(os.PRIO_PROCESS, 0), group.read_text().split()[-1])
"""
HAS_GROUPS = pytest.mark.skipif(
    not priority.AUTOGROUP.is_file(), reason="this kernel does not weigh sessions"
)


def said(script, **options):
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=env,
        stdout=subprocess.PIPE,
        text=True,
        **options,
    )
    assert done.returncode == 0
    return done.stdout.split()


@HAS_GROUPS
def test_a_node_that_gives_way_does_so_with_its_session():
    assert said(SET, start_new_session=True) == ["19", "19", "19"]


@HAS_GROUPS
def test_the_session_of_a_person_at_a_terminal_stays_as_it_is():
    ours, theirs = pty.openpty()

    def log_in():
        os.setsid()
        os.close(os.open(os.ttyname(theirs), os.O_RDWR))  # it becomes the session's terminal

    try:
        assert said(SET, preexec_fn=log_in) == ["19", "19", "0"]
    finally:
        os.close(ours)
        os.close(theirs)


@HAS_GROUPS
@pytest.mark.skipif(os.geteuid() != 0, reason="only root may ask for more than others get")
def test_the_session_of_another_process_is_weighed_alone():
    other = subprocess.Popen(["sleep", "60"], start_new_session=True)
    before = priority.AUTOGROUP.read_text().split()[-1]
    try:
        priority.weigh_session(-7, other.pid)
        assert Path(f"/proc/{other.pid}/autogroup").read_text().split()[-1] == "-7"
        assert priority.AUTOGROUP.read_text().split()[-1] == before
    finally:
        other.kill()
        other.wait()


def test_a_kernel_that_does_not_weigh_sessions_is_no_failure(monkeypatch, tmp_path):
    monkeypatch.setattr(priority, "AUTOGROUP", tmp_path / "none" / "autogroup")
    monkeypatch.setattr(priority, "TERMINAL", tmp_path / "no_terminal")
    priority.weigh_session(10)
    assert not Path(tmp_path / "none").exists()


@pytest.mark.parametrize(
    ("limit", "present", "granted"),
    [(40, 0, -20), (30, 0, -10), (20, 0, 0), (0, 0, 0), (15, 0, 0), (25, -8, -8), (-1, 0, -20)],
)
def test_who_may_not_go_first_gets_as_much_as_is_granted_and_is_told_so(
    monkeypatch, limit, present, granted
):
    """As Linux does it: `nice` of limits.conf bounds what others than root may ask for."""
    state = {"nice": present}

    def ask(_which, _who, nice):
        if nice < state["nice"] and limit != -1 and nice < 20 - limit:
            raise PermissionError
        state["nice"] = nice

    monkeypatch.setattr(priority.os, "setpriority", ask)
    monkeypatch.setattr(priority.os, "getpriority", lambda *_: state["nice"])
    monkeypatch.setattr(priority.resource, "getrlimit", lambda _: (limit, limit))
    weighed = []
    monkeypatch.setattr(priority, "weigh_session", weighed.append)
    assert priority.set_priority(-20) == state["nice"] == granted
    assert weighed == [granted]
