# SPDX-License-Identifier: BSD-3-Clause
"""What users install is all that the product imports, and what tests need is kept apart."""

import ast
import re
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PRODUCT = ("catkin_ws/src", "demo", "support")
OPTIONAL = {"pyarrow"}  # requirements-parquet.txt; the export says what to install
# Files or needs of others; ruckig's module is in no list of importlib.metadata.
NOT_IMPORTED = {"openwakeword", "tiktoken", "more-itertools", "tqdm", "ruckig"}


def named(file):
    """Distributions that a requirements file names."""
    lines = (ROOT / file).read_text(encoding="utf-8").splitlines()
    return {m[1].lower() for line in lines if (m := re.match(r"([\w.-]+)==", line))}


@cache
def imported(*folders):
    """Distributions of the Python environment that the code of these folders imports."""
    found = packages_distributions()
    modules = set()
    for file in (path for folder in folders for path in (ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                modules |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                modules.add(node.module.partition(".")[0])
    return {found[m][0].lower() for m in modules if m in found and not is_debians(m)}


def is_debians(module):
    """Whether ROS or Debian brings it."""
    return any((Path("/usr/lib/python3/dist-packages") / module).glob("*.py"))


def test_users_install_what_the_product_imports():
    needed = imported(*PRODUCT)
    assert needed - named("requirements.txt") - {"pyyaml", "setuptools"} == OPTIONAL


def test_users_install_nothing_that_the_product_does_not_need():
    needed = imported(*PRODUCT) | NOT_IMPORTED | {"pyyaml"}
    assert named("requirements.txt") - needed == set()


@pytest.mark.parametrize("file", ["requirements-dev.txt", "requirements-parquet.txt"])
def test_no_package_is_pinned_in_two_files(file):
    assert not named(file) & named("requirements.txt")


def test_packages_of_debian_are_listed_once():
    lists = [ROOT / "docker" / name for name in ("apt-packages.txt", "apt-packages-dev.txt")]
    names = [line for file in lists for line in file.read_text().split("\n") if line[:1] not in "#"]
    assert len(names) == len(set(names))
