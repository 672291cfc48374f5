# SPDX-License-Identifier: BSD-3-Clause
"""The safety case names tests; each of them must be there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from support.figures import RESULTS, read

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


def test_every_hazard_has_an_id_of_its_own_a_severity_a_guard_and_a_test() -> None:
    rows = [
        row.strip("| ").split(" | ") for row in re.findall(r"^\| [UHEFSN]\d+ \|.*$", TEXT, re.M)
    ]
    assert len(rows) >= 60
    assert len({row[0] for row in rows}) == len(rows)
    for name, severity, hazard, guard, test in rows:
        assert severity in {"A", "B", "C"} and hazard and guard, name
        assert NAMED.findall(test), name


def test_a_claim_names_hazards_that_are_there() -> None:
    ids = set(re.findall(r"^\| ([UHEFSN]\d+) \|", TEXT, re.M))
    claims = re.findall(r"^\| C\d \|.*\| (.*) \|$", TEXT, re.M)
    assert len(claims) == 5
    assert {name for claim in claims for name in re.findall(r"[UHEFSN]\d+", claim)} <= ids


def test_the_longest_time_to_rest_is_the_one_on_file() -> None:
    figures = read(RESULTS / "safety" / "spoken.json")
    longest = max(f.value for f in figures if f.name.endswith("arm and jaws at rest max"))
    (line,) = re.findall(r"^- \*\*A slow processor\*\*.*$", TEXT, re.M)
    assert re.findall(r"(\d+\.\d+) s", line) == [f"{1e-3 * longest:.2f}"]
    assert "robot, controller and voice node alone" in line  # as the bench launches them


def test_a_test_that_does_not_exist_is_missed() -> None:
    assert not is_there("test_lifecycle.py", "test_that_nobody_wrote")
    assert not is_there("test_of_nothing.py", "")
