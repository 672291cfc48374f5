# SPDX-License-Identifier: BSD-3-Clause
"""Every file and name on the pages of the lives and of the formulas is there."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXPLANATION = ROOT / "docs" / "explanation"
PAGE, FORMULAS = (
    (EXPLANATION / f"{name}.md").read_text(encoding="utf-8") for name in ("lives", "rcm-and-paths")
)
ROW = re.compile(r"^\|[^|]*\| `(?P<file>[\w/]+\.py)` \| `(?P<name>[\w.]+)` \|", re.MULTILINE)
ROWS = [(match["file"], match["name"]) for match in ROW.finditer(PAGE)]
FORMULA_ROWS = [(match["file"], match["name"]) for match in ROW.finditer(FORMULAS)]


def source_of(file):
    return ROOT / "catkin_ws" / "src" / file.partition("/")[0] / "src" / file


def is_defined(name, body):
    """Whether a dotted name, such as "Class.function", is defined in statements."""
    first, _, rest = name.partition(".")
    for node in body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and node.name == first:
            return not rest or is_defined(rest, node.body)
    return False


@pytest.mark.parametrize(("file", "name"), [*ROWS, *FORMULA_ROWS])
def test_the_step_is_where_the_page_says(file, name):
    assert is_defined(name, ast.parse(source_of(file).read_text(encoding="utf-8")).body)


def test_the_page_shows_both_lives_from_end_to_end():
    assert len(ROWS) > 25 and len(FORMULA_ROWS) > 12
    assert ROWS.count(("rst_control/execution/executor.py", "Executor.tick")) == 1
    assert ("rst_control/trajectory/motion_profile.py", "MotionProfile.braking") in ROWS


def test_a_name_that_is_not_there_is_noticed():
    body = ast.parse("class A:\n    def b(self): ...\n").body
    assert is_defined("A.b", body)
    assert not is_defined("A.c", body)
    assert not is_defined("b", body)


SETTING = re.compile(r"^\| `(?P<key>\w+)` \| `(?P<file>[\w/]+\.yaml)` \|", re.MULTILINE)


def test_the_settings_on_the_page_are_those_of_their_files():
    settings = [(match["key"], match["file"]) for match in SETTING.finditer(PAGE)]
    assert len(settings) > 10
    for key, file in settings:
        text = (ROOT / file).read_text(encoding="utf-8")
        assert re.search(rf"^\s*{key}:", text, re.MULTILINE), f"{file} has no {key}"
