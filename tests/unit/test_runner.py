# SPDX-License-Identifier: BSD-3-Clause
"""`make test` runs every folder, counts as pytest does and fails when one of its processes does."""

import subprocess
import sys

import pytest

from tests import __main__ as runner

THREE = """
import pytest, time
def test_passes(): time.sleep(0.02)
def test_fails(): assert False
@pytest.mark.skip
def test_skipped(): pass
"""


def test_counts_and_durations_are_those_of_pytest(tmp_path):
    (tmp_path / "test_three.py").write_text(THREE)
    results = tmp_path / "results.xml"
    command = [sys.executable, "-m", "pytest", "-q", str(tmp_path), f"--junitxml={results}"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    none = tmp_path / "none.xml"  # of a process that was killed
    assert runner.count([results, none]) == {"passed": 1, "failed": 1, "skipped": 1}
    (seconds, name), *_ = runner.slowest([results, none])
    assert name == "test_three::test_passes" and seconds >= 0.02


def test_every_folder_of_tests_is_run():
    folder = runner.ROOT / "tests"
    there = [*folder.glob("*/**/test_*.py"), *folder.glob("*/**/*.test")]
    folders = {path.relative_to(folder).parts[0] for path in there}
    assert folders == {*runner.WITH_NODES, *runner.WITHOUT}


@pytest.mark.parametrize(("others", "nodes", "status"), [(0, 0, 0), (1, 0, 1), (0, 2, 1)])
def test_it_fails_when_either_run_fails(monkeypatch, tmp_path, capsys, others, nodes, status):
    codes = iter((others, nodes))
    monkeypatch.setattr(runner, "RESULTS", tmp_path)
    monkeypatch.setattr(runner.subprocess, "call", lambda *_: next(codes))
    assert runner.main([]) == status
    assert next(codes, None) is None  # both were run
    assert capsys.readouterr().out.endswith("\n0 passed, 0 failed, 0 skipped\n")


@pytest.mark.parametrize(
    ("arguments", "are_all"),
    [(["-k", "y"], True), ([__file__, "-k", "y"], False), ([f"{__file__}::test_x"], False)],
)
def test_with_a_path_only_that_is_run(monkeypatch, arguments, are_all):
    ran = []
    monkeypatch.setattr(runner.subprocess, "call", lambda command: ran.append(command) or 0)
    assert runner.main(arguments) == 0
    assert (str(runner.ROOT / "tests") in ran[0]) == are_all


def test_what_is_listed_as_slow_is_there():
    tests = runner.ROOT / "tests"
    lines = (tests / "slow_tests.txt").read_text(encoding="utf-8").splitlines()
    for path, _, test in (line.partition("::") for line in lines if not line.startswith("#")):
        assert (tests / path).exists(), path
        assert f"def {test}" in ((tests / path).read_text("utf-8") if test else "def "), test
