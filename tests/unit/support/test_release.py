# SPDX-License-Identifier: BSD-3-Clause
"""The version stands in one place, and all others follow it."""

import shutil
import subprocess

import pytest

from support.documents.release import ROOT, places, release, version
from tests.support.checkout import needs_git


def found(root):
    return {
        file.relative_to(root): p.search(file.read_text())[2] for file, p in places(root).items()
    }


@pytest.fixture
def copy(tmp_path):
    for file in [*places(), ROOT / "CHANGELOG.md"]:
        target = tmp_path / file.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, target)
    return tmp_path


def test_every_place_has_the_version_of_the_project():
    assert set(found(ROOT).values()) == {version()}


def test_a_release_changes_all_of_them_and_dates_the_changelog(copy):
    release("12.3.4", "2026-12-01", copy)
    assert set(found(copy).values()) == {"12.3.4"} == {version(copy)}
    changelog = (copy / "CHANGELOG.md").read_text("utf-8")
    assert "## [Unreleased]\n\n## [12.3.4] - 2026-12-01\n" in changelog


def test_a_changelog_without_an_unreleased_part_is_refused_and_nothing_written(copy):
    before = found(copy)
    (copy / "CHANGELOG.md").write_text("# Changelog\n")
    with pytest.raises(ValueError, match="has no line '## \\[Unreleased\\]'"):
        release("12.3.4", "2026-12-01", copy)
    assert found(copy) == before


def test_the_changelog_has_the_parts_of_its_form():
    text = (ROOT / "CHANGELOG.md").read_text("utf-8")
    headings = [line for line in text.splitlines() if line.startswith("### ")]
    assert headings and set(headings) <= {
        *("### Added", "### Changed", "### Deprecated", "### Removed", "### Fixed", "### Security")
    }


@needs_git
def test_every_source_file_bears_its_licence():
    listed = subprocess.run(
        ["git", "ls-files", "*.py", "*.sh", "*.launch", "*.test"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    files = [ROOT / name for name in listed if (ROOT / name).is_file()]
    assert len(files) > 500
    assert not [
        f for f in files if "SPDX-License-Identifier: BSD-3-Clause" not in f.read_text()[:300]
    ]
