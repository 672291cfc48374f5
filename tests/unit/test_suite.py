# SPDX-License-Identifier: BSD-3-Clause
"""`make test` counts what both of its processes did, and fails when one of them does."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests import __main__ as suite

ROOT = Path(__file__).resolve().parents[2]
CONFTEST = f"""
import importlib.util, sys
sys.path.insert(0, {str(ROOT)!r})
spec = importlib.util.spec_from_file_location("of_all", {str(ROOT / "tests" / "conftest.py")!r})
of_all = importlib.util.module_from_spec(spec)
spec.loader.exec_module(of_all)
pytest_runtest_logreport = of_all.pytest_runtest_logreport
"""
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
    folders = {path.parent.relative_to(ROOT / "tests").parts[0] for path in all_there()}
    assert folders == {*suite.WITH_NODES, *suite.WITHOUT}


def all_there():
    folder = ROOT / "tests"
    return [*folder.glob("*/**/test_*.py"), *folder.glob("*/**/*.test")]


class Ended:
    """A process that has ended."""

    def __init__(self, status):
        self.wait = self.poll = lambda: status


@pytest.mark.parametrize(("first", "other", "status"), [(0, 0, 0), (1, 0, 1), (0, 2, 1)])
def test_it_fails_when_either_fails(monkeypatch, capsys, first, other, status):
    monkeypatch.setattr(suite.subprocess, "Popen", lambda *_, **__: Ended(other))
    monkeypatch.setattr(suite.subprocess, "call", lambda *_, **__: first)
    assert suite.main([]) == status
    assert "0 passed, 0 failed, 0 skipped" in capsys.readouterr().out


PASSES = "def test_it(): pass"
FAILS = "def test_it(): assert False"
IN_A_CROWD = """
import os
def test_it(): assert not os.environ.get("FAILED_TESTS")  # as if the others were in its way
"""


@pytest.mark.parametrize(
    ("with_nodes", "without", "status", "last"),
    [
        ([PASSES], PASSES, 0, "2 passed, 0 failed, 0 skipped"),
        ([IN_A_CROWD], PASSES, 0, "2 passed, 0 failed, 0 skipped; 1 of them run again alone"),
        ([FAILS], PASSES, 1, "1 passed, 1 failed, 0 skipped; 1 of them run again alone"),
        ([PASSES], IN_A_CROWD, 0, "2 passed, 0 failed, 0 skipped; 1 of them run again alone"),
        ([PASSES], FAILS, 1, "1 passed, 1 failed, 0 skipped; 1 of them run again alone"),
        ([IN_A_CROWD], FAILS, 1, "1 passed, 1 failed, 0 skipped; 2 of them run again alone"),
        ([FAILS] * (suite.MOST_AGAIN + 1), PASSES, 1, "1 passed, 6 failed, 0 skipped"),
    ],
)
def test_what_failed_beside_the_others_is_run_again_alone(
    tmp_path, monkeypatch, capfd, with_nodes, without, status, last
):
    tests = tmp_path / "tests"
    for folder, texts in (("rostest", with_nodes), ("unit", [without])):
        (tests / folder).mkdir(parents=True)
        for index, text in enumerate(texts):
            (tests / folder / f"test_{folder}_{index}.py").write_text(text)
    (tests / "conftest.py").write_text(CONFTEST)
    (tmp_path / "pyproject.toml").write_text("[tool.pytest.ini_options]\n")
    monkeypatch.setattr(suite, "FOLDER", tests)
    monkeypatch.setattr(suite, "WITH_NODES", ("rostest",))
    monkeypatch.setattr(suite, "WITHOUT", ("unit",))
    monkeypatch.chdir(tmp_path)
    assert suite.main([]) == status
    printed = capfd.readouterr().out
    assert printed.rstrip().endswith(last), printed


def test_what_was_broken_off_is_not_run_again(monkeypatch, tmp_path):
    """Pytest's exit code 2: some tests were never run, whatever those that failed do alone."""

    def call(command, env=None):
        assert env, "nothing is run again"
        Path(env["FAILED_TESTS"]).write_text("tests/one.py::test_it\n")
        return 2

    monkeypatch.setattr(suite.subprocess, "Popen", lambda *_, **__: Ended(0))
    monkeypatch.setattr(suite.subprocess, "call", call)
    assert suite.main([]) == 1
