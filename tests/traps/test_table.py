# SPDX-License-Identifier: BSD-3-Clause
"""The table of traps names only tests that exist, and all tests of this folder."""

import ast
import re
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
NAMED = re.findall(r"`(tests/[a-z_/]+\.py)::(test_\w+)`", (HERE / "README.md").read_text("utf-8"))


def functions_in(file):
    """Names of the test functions at the top of a file."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_every_test_of_the_table_exists():
    missing = [f"{file}::{name}" for file, name in NAMED if name not in functions_in(ROOT / file)]
    assert len(NAMED) > 30
    assert missing == []


def test_every_trap_here_is_in_the_table():
    named = {name for _, name in NAMED}
    for file in HERE.glob("test_*_traps.py"):
        tests = {name for name in functions_in(file) if name.startswith("test_")}
        assert tests and tests <= named, tests - named
