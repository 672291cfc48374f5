# SPDX-License-Identifier: BSD-3-Clause
"""The safety case names tests; each of them must be there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NAMED = re.compile(r"`(?P<file>\w+\.py)(?:::(?P<test>\w+))?`")
TEXT = (ROOT / "docs" / "safety.md").read_text(encoding="utf-8")
EVIDENCE = sorted({(match["file"], match["test"] or "") for match in NAMED.finditer(TEXT)})


def is_there(file: str, test: str) -> bool:
    """Whether a test file of that name exists and holds the test."""
    found = list((ROOT / "tests").rglob(file))
    wanted = f"def {test}(" if test else "def test_"
    return any(wanted in path.read_text(encoding="utf-8") for path in found)


@pytest.mark.parametrize(("file", "test"), EVIDENCE)
def test_what_the_safety_case_cites_exists(file: str, test: str) -> None:
    assert is_there(file, test), f"docs/safety.md cites {file}::{test}, which is not there"


def test_every_hazard_cites_a_test() -> None:
    rows = [line for line in TEXT.splitlines() if re.match(r"\| [ABC]: ", line)]
    assert len(rows) >= 25
    assert not [row for row in rows if not NAMED.search(row.split("|")[3])]


def test_a_test_that_does_not_exist_is_missed() -> None:
    assert not is_there("test_lifecycle.py", "test_that_nobody_wrote")
    assert not is_there("test_of_nothing.py", "")
