# SPDX-License-Identifier: BSD-3-Clause
"""`roslaunch --ros-args` explains every argument of every launch file."""

from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest
from roslaunch.arg_dump import get_args

LAUNCH = Path(__file__).resolve().parents[2] / "launch"
FILES = sorted(LAUNCH.glob("*.launch"))
LEAST_WORDS = 3


def declared(file):
    """Arguments that a file takes: those of its top level without a fixed value."""
    arguments = Xml.parse(file).getroot().findall("arg")
    return {arg.attrib["name"]: arg.attrib for arg in arguments if "value" not in arg.attrib}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_roslaunch_shows_words_that_explain_each_argument(file):
    """What it prints is taken from its own reader, which follows includes."""
    shown = get_args([str(file)])
    for name, attributes in declared(file).items():
        doc = attributes.get("doc", "")
        assert len(doc.split()) >= LEAST_WORDS, f"{file.name}: {name} has no doc string of its own"
        assert doc.split() != name.split("_"), f"{file.name}: {name} is explained by its name"
        assert shown[name][0], f"{file.name}: roslaunch --ros-args shows nothing for {name}"
        assert "default" in attributes or doc.startswith("required"), f"{file.name}: {name}"
