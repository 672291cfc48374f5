# SPDX-License-Identifier: BSD-3-Clause
"""The figures of docs/how-to/kinova.md are those that the benches wrote."""

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "how-to" / "kinova.md").read_text(encoding="utf-8")
FIGURES = {
    figure["name"]: figure["value"]
    for figure in json.loads(
        (ROOT / "bench" / "results" / "torque_tension.json").read_text(encoding="utf-8")
    )["figures"]
}
ROWS = {  # row of the table, and how its figures are called
    "with tare, shaft leaning on the trocar": "tared, shaft leans on the trocar",
    "the same, where it is trusted": "tared, shaft leans on the trocar, where trusted",
    "with tare, shaft free in the trocar": "tared, shaft free in the trocar",
    "without tare (never trusted)": "not tared, shaft leans on the trocar",
    "with tare, the trocar's push taken for nothing, as simpler estimators do": (
        "tared, trocar taken for no load at all"
    ),
    "with tare, 1 N of friction in the trocar's seal": (
        "tared, 1 N of friction in the trocar's seal"
    ),
}
COLUMNS = ("bias", "sigma of the error", "95 % of errors below")


@pytest.mark.parametrize("row", ROWS)
def test_the_table_of_joint_torques_is_the_benchs(row):
    (line,) = [line for line in PAGE.splitlines() if line.startswith(f"| {row} |")]
    shown = [cell.split()[0] for cell in line.split("|")[2:5]]
    assert shown == [f"{FIGURES[f'{ROWS[row]}: {column}']:.2f}" for column in COLUMNS]


def shown(pattern):
    """Numbers in a sentence of the page."""
    found = re.search(pattern, " ".join(PAGE.split()))
    assert found, pattern
    return list(found.groups())


def test_the_sentences_beside_it_are_too():
    trusted, within = shown(r"Of the first, (\d+) % are trusted, and (\d+) % are within twice")
    name = "tared, shaft leans on the trocar"
    assert trusted == f"{100 * FIGURES[f'{name}: trusted']:.0f}"
    assert within == f"{100 * FIGURES[f'{name}: errors within twice the sigma told']:.0f}"
    highest, most = shown(r"at most ([\d.]+) N where .* asked for, 95 % within ([\d.]+) N")
    assert highest == f"{FIGURES['pulls led by it: highest true tension']:.2f}"
    assert most == f"{FIGURES['pulls led by it: 95 % of tensions within']:.2f}"
