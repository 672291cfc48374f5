# SPDX-License-Identifier: BSD-3-Clause
"""The cost of set-up is that of a clone, whatever lies in the folder it is cloned from."""

import subprocess

import pytest

from bench.system.setup import measure

MAKEFILE = """
setup:
	@mkdir .venv && head -c 3000000 /dev/urandom > .venv/package
	@test -z "$$MAKEFILES" && test -f there
"""


@pytest.fixture
def repository(tmp_path):
    """One whose set-up makes an environment of 3 MB."""
    root = tmp_path / "root"
    root.mkdir()
    (root / "Makefile").write_text(MAKEFILE)
    (root / "there").touch()
    git(root, "init", "--quiet")
    git(root, "add", ".")
    git(root, "-c", "user.name=a", "-c", "user.email=a@b", "commit", "--quiet", "-m", "all")
    return root


def git(root, *words):
    subprocess.run(["git", *words], cwd=root, check=True)


def test_time_and_size_are_those_of_a_fresh_clone(repository):
    (repository / ".venv").mkdir()  # of this folder, not of a clone
    found = {figure.name: figure.value for figure in measure(repository)}
    assert found["set-up: on disk, Python packages"] == pytest.approx(3.0, abs=0.2)
    assert found["set-up: on disk, all"] >= found["set-up: on disk, Python packages"]
    assert found["set-up: on disk, workspace"] == 0.0
    assert found["set-up: time"] > 0.0


def test_a_set_up_that_fails_ends_with_what_it_printed(repository):
    git(repository, "rm", "--quiet", "there")
    git(repository, "-c", "user.name=a", "-c", "user.email=a@b", "commit", "--quiet", "-m", "less")
    with pytest.raises(RuntimeError, match=r"make setup failed:[\s\S]*Error 1"):
        measure(repository)
