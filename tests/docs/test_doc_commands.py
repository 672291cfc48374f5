# SPDX-License-Identifier: BSD-3-Clause
"""There is one table of commands in the documents, and it is that of the code."""

from __future__ import annotations

import re
from pathlib import Path

from rst_control.commands.table import markdown

ROW = re.compile(r"^\| `?(?:hey robot|tense|terminate)`? \|.*$", re.MULTILINE)
DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_table_of_commands_is_that_of_the_code():
    assert markdown() in (DOCS / "reference" / "commands.md").read_text("utf-8"), markdown()


def test_no_other_page_says_what_each_command_does():
    for page in DOCS.rglob("*.md"):
        rows = re.findall(
            r"^\| `?(?:hey robot|tense|terminate)`? \|.*$", page.read_text(), re.MULTILINE
        )
        assert len(rows) == (3 if page.name == "commands.md" else 0), (page.name, rows)
