# SPDX-License-Identifier: BSD-3-Clause
"""Writes the tables of a report for LaTeX, with booktabs."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from session_log.report.pool.pool import Pool
from session_log.report.tables import pool_tables
from session_log.report.tables.text_table import TextTable

WIDE = 62  # [letters] a wider table spans both columns of a paper
ALL_NAME = "tables.tex"
_WORDS = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "[": "{[}",  # bare, it would be an argument of the line break before it
    "]": "{]}",
    "*": "{*}",
    "\u00a0": "~",
    "–": "--",
    "“": "``",
    "”": "''",
    "…": r"\ldots{}",
    "µ": r"\textmu{}",
    "°": r"\textdegree{}",
    "·": r"\textperiodcentered{}",
}


@dataclass(frozen=True)
class _Titled:
    name: str
    caption: str
    table: TextTable


def write_latex(pool: Pool, folder: Path) -> list[Path]:
    r"""Write each table that the pool has numbers for, and `tables.tex`, which shows them all.

    The files need `\usepackage{booktabs}` and pdfLaTeX of 2020 or later, or XeLaTeX.

    Raises:
        OSError: The folder cannot be written.
    """
    written = []
    for titled in _tables(pool):
        path = folder / f"{titled.name}.tex"
        path.write_text(table_text(titled.table, titled.caption, titled.name), encoding="utf-8")
        written.append(path)
    if written:
        inputs = "\n".join(rf"\input{{{path.stem}}}" for path in written)
        (folder / ALL_NAME).write_text(
            "\\documentclass[twocolumn]{article}\n\\usepackage{booktabs}\n\\begin{document}\n"
            f"{inputs}\n\\end{{document}}\n",
            encoding="utf-8",
        )
        written.append(folder / ALL_NAME)
    return written


def table_text(table: TextTable, caption: str, label: str) -> str:
    """Set one table as a floating environment; numbers stand to the right."""
    environment = "table*" if _width(table) > WIDE else "table"
    form = "".join("r" if i in table.numbers else "l" for i in range(len(table.columns)))
    lines = [
        rf"\begin{{{environment}}}",
        r"  \centering",
        r"  \footnotesize",
        r"  \setlength{\tabcolsep}{4pt}",
        rf"  \caption{{{escape(caption)}}}",
        rf"  \label{{tab:{label}}}",
        rf"  \begin{{tabular}}{{{form}}}",
        r"    \toprule",
        "    " + _row(_head(column) for column in table.columns),
        r"    \midrule",
    ]
    for line in table.lines():
        if line.mark == "total":
            lines.append(r"    \midrule")
        lines.append("    " + _row(escape(cell) for cell in line.cells))
    lines += [r"    \bottomrule", r"  \end{tabular}", rf"\end{{{environment}}}"]
    return "\n".join(lines) + "\n"


def escape(words: str) -> str:
    """Write plain words so that LaTeX shows them as they are; control characters become spaces."""
    plain = re.sub(r"[\x00-\x1f\x7f]+", " ", words)
    return "".join(_WORDS.get(letter, letter) for letter in plain)


def _tables(pool: Pool) -> list[_Titled]:
    paper = pool.config.paper
    found = []
    if pool.knows_intent:
        text = "Phrases taken as they were meant, by command, with exact confidence intervals."
        found.append(_Titled("accuracy", text, pool_tables.accuracy_table(pool)))
    if pool.confusions:
        text = "What was meant (rows) against what it was taken for (columns)."
        found.append(_Titled("confusion", text, pool_tables.confusion_table(pool)))
    if pool.latencies().decision:
        text = (
            "Time after the end of speech by command, with exact 95 % confidence bounds in "
            f"brackets, beside {paper.source} ({paper.hardware})."
        )
        found.append(_Titled("latency", text, pool_tables.latency_table(pool)))
    if (motion := pool_tables.motion_table(pool)).rows:
        text = "Error of the remote centre of motion (RCM) and tissue tension."
        found.append(_Titled("motion", text, motion))
    return found


def _width(table: TextTable) -> int:
    """Letters of the widest cell of each column, with the space between them."""
    columns = zip(*table.rows, strict=True) if table.rows else ()
    widest = [max(map(len, cells)) for cells in columns]
    titles = [max(map(len, _halves(column))) for column in table.columns]
    return sum(map(max, zip(widest or titles, titles, strict=True))) + 2 * len(titles)


def _head(column: str) -> str:
    """A title of several words stands in two lines."""
    upper, lower = _halves(column)
    return rf"\shortstack{{{escape(upper)}\\{escape(lower)}}}" if lower else escape(upper)


def _halves(column: str) -> tuple[str, str]:
    words = column.split(" ")
    middle = (len(words) + 1) // 2
    return " ".join(words[:middle]), " ".join(words[middle:])


def _row(cells: Iterable[str]) -> str:
    return " & ".join(cells) + r" \\"
