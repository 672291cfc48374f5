# SPDX-License-Identifier: BSD-3-Clause
"""Environment variables that the product reads or sets: docs/reference/programs.md has each."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.figures import ROOT

PACKAGES = ROOT / "catkin_ws" / "src"
NOT_OURS = {"PATH", "HOME", "TMPDIR"}  # of every shell
METHODS = {"os.environ.get", "os.environ.setdefault", "os.getenv"}


def variables(text: str) -> Iterator[str]:
    """Names of the variables that a module asks for or sets; a name may be a constant of it."""
    tree = ast.parse(text)
    named = {
        target.id: node.value.value
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func) in METHODS:
            name = node.args[0]
            yield name.value if isinstance(name, ast.Constant) else named[ast.unparse(name)]
        elif isinstance(node, ast.Subscript) and ast.unparse(node.value) == "os.environ":
            yield ast.literal_eval(node.slice)


def of_the_product() -> set[str]:
    """Those of all packages, and of what a workspace's set-up file sets."""
    files = [f for f in PACKAGES.glob("*/src/**/*.py") if "training" not in f.parts]
    texts = [text for file in files if "env" in (text := file.read_text("utf-8"))]
    found = {name for text in texts for name in variables(text)}
    hook = next(PACKAGES.glob("typed_config/env-hooks/*.sh.in")).read_text("utf-8")
    return (found | set(re.findall(r"export ([A-Z_]+)=", hook))) - NOT_OURS


def test_every_variable_stands_in_the_documents_and_no_other():
    text = Path(ROOT, "docs/reference/programs.md").read_text("utf-8")
    section = text.split("## Environment variables")[1].split("\n## ")[0]
    documented = set(re.findall(r"^\| `([A-Z_]+)` \|", section, re.MULTILINE))
    assert documented == of_the_product()


@pytest.mark.parametrize(
    "line",
    ['os.environ.get("A")', 'os.getenv("A", "b")', "os.environ.setdefault(NAME, '1')"],
)
def test_a_variable_is_found_by_its_name_or_a_constant(line):
    assert list(variables(f'NAME = "A"\nx = {line}')) == ["A"]
