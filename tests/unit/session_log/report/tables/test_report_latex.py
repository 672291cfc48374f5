# SPDX-License-Identifier: BSD-3-Clause
"""The tables for LaTeX: balanced, escaped, with as many cells as columns."""

import re
import shutil
import subprocess

import pytest
from hypothesis import given
from hypothesis import strategies as st

from session_log.mcap_file.reader import SessionReader
from session_log.report import one_session
from session_log.report.one_session import write_report
from session_log.report.tables.latex import escape, table_text
from session_log.report.tables.text_table import TextTable
from support.story import recording_of

SPECIAL = re.compile(r"(?<!\\)[&%$#_]")


def structure(text):
    """Environments in order, column form, and the cells of each row."""
    open_ones, depth = [], 0
    for kind, name in re.findall(r"\\(begin|end)\{([a-z*]+)\}", text):
        if kind == "begin":
            open_ones.append(name)
        else:
            assert open_ones.pop() == name
    assert open_ones == []
    for letter in re.sub(r"\\[\\{}]", "", text):
        depth += {"{": 1, "}": -1}.get(letter, 0)
        assert depth >= 0
    assert depth == 0
    assert not re.search(r"\\\\\s*[\[*]", text)  # would be an argument of the line break
    form = re.search(r"\\begin\{tabular\}\{([lr]+)\}", text).group(1)
    lines = [line.strip() for line in text.splitlines() if line.rstrip().endswith(r"\\")]
    rows = [re.split(r"(?<!\\)&", line.removesuffix(r"\\")) for line in lines]
    return form, [[cell.strip() for cell in row] for row in rows]


@pytest.fixture(scope="module")
def written(story, report_config, tmp_path_factory):
    folder = tmp_path_factory.mktemp("latex")
    with pytest.MonkeyPatch.context() as patch:
        for figures in ("SESSION_FIGURES", "POOL_FIGURES"):
            patch.setattr(one_session, figures, ())
        return write_report(SessionReader(story[0]), folder, report_config, latex=True).latex


def test_every_table_is_written_and_one_file_shows_them_all(written):
    names = ["accuracy", "confusion", "latency", "motion", "tables"]
    assert [path.stem for path in written] == names
    whole = written[-1].read_text(encoding="utf-8")
    assert re.findall(r"\\input\{(\w+)\}", whole) == names[:-1]
    assert r"\usepackage{booktabs}" in whole


def test_tables_are_balanced_and_have_a_cell_for_each_column(written):
    for path in written[:-1]:
        text = path.read_text(encoding="utf-8")
        form, rows = structure(text)
        assert len(rows) > 1
        assert all(len(row) == len(form) for row in rows), path.name
        assert [text.count(rule) for rule in (r"\toprule", r"\bottomrule")] == [1, 1]
        assert not any(ord(letter) > 127 for letter in text), path.name


def test_our_latency_and_the_papers_are_in_one_row(written):
    latency = next(p for p in written if p.stem == "latency").read_text(encoding="utf-8")
    _, rows = structure(latency)
    tense = next(row for row in rows if row[0] == "tense")
    assert tense[1] == "1" and tense[-1] == "1.14"
    assert "arXiv:2409.10225" in latency


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("50 % & more", r"50 \% \& more"),
        ("a_b^c~d", r"a\_b\textasciicircum{}c\textasciitilde{}d"),
        (r"\input{x}", r"\textbackslash{}input\{x\}"),
        ("“hey”\u00a0– 5 µm", "``hey''~-- 5 \\textmu{}m"),
        ("two\nlines", "two lines"),
        ("[s] *", "{[}s{]} {*}"),
    ],
)
def test_special_letters_are_escaped(words, expected):
    assert escape(words) == expected


@given(st.lists(st.lists(st.text(max_size=12), min_size=3, max_size=3), max_size=5))
def test_any_words_leave_the_structure_whole(rows):
    table = TextTable(("a", "b c", "d"), [tuple(row) for row in rows], numbers=(1,))
    text = table_text(table, "caption", "label")
    form, found = structure(text)
    assert form == "lrl" and len(found) == len(rows) + 1
    assert all(len(row) == 3 for row in found)
    for row in found[1:]:
        assert not any(SPECIAL.search(cell) for cell in row)


def test_a_session_without_anything_has_no_tables(tmp_path, report_config):
    report = write_report(recording_of(tmp_path / "s.mcap"), tmp_path, report_config, latex=True)
    assert report.latex == [] and not list(tmp_path.glob("*.tex"))


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
def test_the_tables_compile(written):
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "tables.tex"]
    done = subprocess.run(
        command, cwd=written[0].parent, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:]
