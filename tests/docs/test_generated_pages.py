# SPDX-License-Identifier: BSD-3-Clause
"""What the documents take from code and settings is up to date, and stands nowhere else."""

import re

import pytest
import yaml

from support.documents.pages import PACKAGES, ROOT, SOURCES, pages, read_settings, with_block

MADE = pages()
SAMPLE = """# About the file.
rate: 500.0   # [Hz] how often
speed:        # of all
  tip: 0.02   # [m/s] of the tip,
              #   or | less
words: {a: 1}
commands:
  - phrase: x
    threshold: 1
last: yes     # [-] after the list
"""


@pytest.mark.parametrize("page", sorted(MADE), ids=lambda page: page.name)
def test_a_page_is_what_code_and_settings_make_of_it(page):
    assert page.read_text("utf-8") == MADE[page], "run: python -m support.documents.pages"


def test_keys_are_read_with_path_value_and_the_whole_comment():
    about, settings = read_settings(SAMPLE)
    assert about == "About the file."
    assert [(s.name, s.value) for s in settings] == [
        ("rate", "500.0"),
        ("speed", ""),
        ("speed.tip", "0.02"),
        ("words", "{a: 1}"),
        ("last", "yes"),
    ]
    assert settings[2].row() == r"| `speed.tip` | `0.02` | [m/s] of the tip, or \| less |"


def test_no_key_of_a_settings_file_is_left_out():
    for package in PACKAGES:
        for file in (SOURCES / package / "config").glob("*.yaml"):
            text = file.read_text("utf-8")
            named = {s.name for s in read_settings(text)[1]}
            missing = set(keys(yaml.load(text, yaml.CSafeLoader))) - named
            assert not missing, (file.name, missing)


def keys(tree, above=""):
    """Paths of all values but those in lists."""
    for name, value in tree.items():
        if isinstance(value, dict) and value:
            yield from keys(value, f"{above}{name}.")
        elif not (isinstance(value, list) and value and isinstance(value[0], dict)):
            yield f"{above}{name}"


def test_marks_that_are_missing_are_named():
    with pytest.raises(ValueError, match="0 blocks are marked '<!-- generated: a -->', allowed: 1"):
        with_block("no marks", "a", "text")


def test_no_other_page_says_what_each_command_does():
    for page in (ROOT / "docs").rglob("*.md"):
        rows = re.findall(
            r"^\| `?(?:hey robot|tense|terminate)`? \|.*$", page.read_text(), re.MULTILINE
        )
        assert len(rows) == (3 if page.name == "commands.md" else 0), (page.name, rows)
