# SPDX-License-Identifier: BSD-3-Clause
"""`make test` runs every folder of tests and fails when one of its processes does."""

import pytest

from tests import __main__ as runner


def test_every_folder_of_tests_is_run():
    folder = runner.ROOT / "tests"
    there = [*folder.glob("*/**/test_*.py"), *folder.glob("*/**/*.test")]
    folders = {path.relative_to(folder).parts[0] for path in there}
    assert folders == {*runner.WITH_NODES, *runner.WITHOUT}


def test_what_is_named_is_there_and_has_nodes():
    for place in (*runner.DEMO, *runner.HEARING):
        assert (runner.ROOT / "tests" / place).exists(), place
        assert place.partition("/")[0] in runner.WITH_NODES


def test_every_file_with_nodes_runs_once():
    folder = runner.ROOT / "tests"
    named = [folder / place for place in (*runner.DEMO, *runner.HEARING, *runner.deaf_systems())]
    for top in runner.WITH_NODES:
        for kind in runner.KINDS:
            for path in (folder / top).rglob(kind):
                assert sum(path.is_relative_to(place) for place in named) == 1, path


class Ended:
    """A process that has ended."""

    def __init__(self, status):
        self.wait = self.poll = lambda: status


@pytest.mark.parametrize(("nodes", "others", "status"), [(0, 0, 0), (1, 0, 1), (0, 2, 1)])
def test_it_fails_when_either_run_fails(monkeypatch, tmp_path, capsys, nodes, others, status):
    monkeypatch.setattr(runner, "RESULTS", tmp_path)
    monkeypatch.setattr(runner, "BESIDE", tmp_path / "others.log")
    monkeypatch.setattr(runner.subprocess, "Popen", lambda *_, **__: Ended(others))
    monkeypatch.setattr(runner.subprocess, "call", lambda *_, **__: nodes)
    assert runner.main([]) == status
    assert capsys.readouterr().out.endswith("\n0 passed, 0 failed, 0 skipped\n")


def test_what_is_listed_as_slow_is_there():
    tests = runner.ROOT / "tests"
    lines = (tests / "slow_tests.txt").read_text(encoding="utf-8").splitlines()
    for path, _, test in (line.partition("::") for line in lines if not line.startswith("#")):
        assert (tests / path).exists(), path
        assert f"def {test}" in ((tests / path).read_text("utf-8") if test else "def "), test
