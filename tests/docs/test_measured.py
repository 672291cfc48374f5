# SPDX-License-Identifier: BSD-3-Clause
"""docs/measured.md and the README's figures are those of bench/results: else `make figures`."""

import json
import re

import pytest

from bench import page
from bench.catalogue import parts
from bench.readme_rows import ROWS
from support.figures import RESULTS, ROOT, read

TEXT = page.PAGE.read_text(encoding="utf-8")
FRONT = page.FRONT.read_text(encoding="utf-8")


def table(text):
    """Rows of cells of all tables, by their heads."""
    found, head = [], []
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|---"):
            continue
        if not line.startswith("| "):
            head = []
        elif not head:
            head = cells
        else:
            found.append(dict(zip(head, cells, strict=True)))
    return found


def ageless(text):
    """The page without what it says of the code's age, which changes with each change of it."""
    for words in page.AGES.values():
        text = text.replace(words, "")
    return re.sub(r"(?s)Of these verdicts \d+ are of .*?Of \d+ it is not recorded", "", text)


def test_the_page_is_made_of_the_results_on_file():
    assert ageless(page.text()) == ageless(TEXT), "make figures"


def test_the_readmes_figures_are_made_of_the_results_on_file():
    assert page.in_readme(FRONT) == FRONT, "make figures"


def test_every_figure_has_a_target_or_says_that_it_has_none():
    every = table(TEXT)
    assert len(every) > 300
    assert not [
        row for row in every if not row["target"].startswith(("at most ", "at least ", "none"))
    ]
    verdicts = {row["target"] == "none": set() for row in every}
    for row in every:
        if "result" in row:  # not in the list of missed ones
            verdicts[row["target"] == "none"].add(row["result"])
    said = {"met", page.FEW, page.UNBOUND, "**missed**"}
    assert verdicts[False] <= said and verdicts[True] == {"-"}


def test_no_share_or_rate_is_met_without_a_bound_or_a_word_about_it():
    shares = [
        row
        for row in table(TEXT)
        if row.get("unit") in ("%", "per h") and not row["figure"].endswith("max")
    ]
    assert len(shares) > 100
    assert not [r for r in shares if r.get("result") == "met" and r.get("95 %", "-") == "-"]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.words)
def test_each_number_in_the_readme_is_the_results(row):
    (shown,) = [
        c for c in table(FRONT) if c.get("figure", "").split(" (")[0] == row.words.split(" (")[0]
    ]
    (figure,) = [
        f for f in read(RESULTS / f"{row.part.replace('.', '/')}.json") if f.name == row.figure
    ]
    scale = 100.0 if figure.unit == "of all" else 1.0
    assert float(shown["measured"].split()[0]) == pytest.approx(scale * figure.value, rel=5e-3)
    assert (shown["result"] == "**missed**") == (figure.is_met is False)
    if figure.target is not None:
        assert float(shown["target"].split()[-1]) == pytest.approx(scale * figure.target, rel=5e-4)


def test_the_readme_has_six_to_eight_figures_and_missed_ones_among_them():
    shown = [cells for cells in table(FRONT) if "result" in cells]
    assert 6 <= len(shown) <= 8
    assert any(cells["result"] == "**missed**" for cells in shown)


def test_every_result_on_file_is_some_parts():
    known = {part.file for part in parts()}
    results = [path for path in RESULTS.rglob("*.json") if is_result(path)]
    names = {path.relative_to(RESULTS).with_suffix("").as_posix() for path in results}
    assert names <= known, "a row of bench/catalogue.py is missing"


def is_result(path):
    """Whether a file holds figures of a machine, and not what lies behind them."""
    data = json.loads(path.read_text(encoding="utf-8"))
    return "losses_rows" not in path.parts and isinstance(data, dict) and "machine" in data


def test_links_of_the_page_lead_to_files():
    for line in TEXT.splitlines():
        for target in [part.split(")")[0] for part in line.split("](")[1:]]:
            assert (ROOT / "docs" / target).is_file(), target
