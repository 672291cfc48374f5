# SPDX-License-Identifier: BSD-3-Clause
"""`make test` counts what both of its processes did, and fails when one of them does."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests import __main__ as suite

ROOT = Path(__file__).resolve().parents[2]
THREE = """
import pytest
def test_passes(): pass
def test_fails(): assert False
@pytest.mark.skip
def test_skipped(): pass
"""


def test_counts_are_those_of_pytest(tmp_path):
    (tmp_path / "test_three.py").write_text(THREE)
    results = tmp_path / "results.xml"
    command = [sys.executable, "-m", "pytest", "-q", str(tmp_path), f"--junitxml={results}"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    assert suite.count(results) == {"passed": 1, "failed": 1, "skipped": 1}


def test_a_process_that_left_no_results_counts_nothing(tmp_path):
    assert suite.count(tmp_path / "none.xml") == {}


def test_every_folder_of_tests_is_in_one_of_the_two_groups():
    folders = {path.parent.relative_to(ROOT / "tests").parts[0] for path in tests_there()}
    assert folders == {*suite.WITH_NODES, *suite.WITHOUT}


def tests_there():
    folder = ROOT / "tests"
    return [*folder.glob("*/**/test_*.py"), *folder.glob("*/**/*.test")]


@pytest.mark.parametrize(("first", "other", "status"), [(0, 0, 0), (1, 0, 1), (0, 2, 1)])
def test_it_fails_when_either_fails(monkeypatch, capsys, first, other, status):
    class Ended:
        def wait(self):
            return other

        def poll(self):
            return other

    monkeypatch.setattr(suite.subprocess, "Popen", lambda *_, **__: Ended())
    monkeypatch.setattr(suite.subprocess, "call", lambda *_, **__: first)
    assert suite.main([]) == status
    assert "0 passed, 0 failed, 0 skipped" in capsys.readouterr().out
