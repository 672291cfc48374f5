# SPDX-License-Identifier: BSD-3-Clause
"""Every argument of every launch file arrives at the node or setting that it is meant for."""

import functools
import shutil

import pytest

from tests.support.argument_places import ROOT, bases, rows, unmet
from tests.support.launch_reading import read
from typed_config.launch_line import arguments

LAUNCH = ROOT / "launch"
PACKAGES = ROOT / "catkin_ws" / "src"
LIMITS = PACKAGES / "rst_control" / "config" / "kinova_limits.yaml"
URDF = PACKAGES / "rst_control" / "urdf" / "gen3_openrst.urdf"


@functools.cache
def reading(file, *more):
    """A file with the arguments of its base and more, in which a later one counts."""
    words = [word.replace("@kinova_limits", str(LIMITS)) for word in (*bases()[file], *more)]
    last = {word.partition(":=")[0]: word for word in words}
    return read([str(LAUNCH / file), *last.values()])


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    """A value that can be told from the default: files get a setting of their own."""
    folder = tmp_path_factory.mktemp("own settings")

    def sample(word):
        if not word.startswith("@"):
            return word
        kept = folder / word[1:]
        if word == "@text":
            kept.write_text(URDF.read_text("utf-8") + "<!-- another -->\n", "utf-8")
        elif word == "@file":
            kept.write_text("{of_this_test: {file: 1}}\n", "utf-8")
        elif not kept.exists():
            for package in ("rst_control", "voice_assist", "session_log"):
                shutil.copytree(PACKAGES / package / "config", kept, dirs_exist_ok=True)
            for file in kept.glob("*.yaml"):
                with file.open("a", encoding="utf-8") as text:
                    text.write(f"\nof_this_test: {file.name}\n")
        return str(kept)

    return sample


def test_the_table_has_every_argument_of_every_file():
    declared = {(f.name, name) for f in LAUNCH.glob("*.launch") for name in arguments(f)}
    assert {(row.file, row.name) for row in rows()} == declared


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row.file.split('.')[0]}-{row.name}")
def test_an_argument_reaches_its_places(row, sample):
    value = sample(row.sample)
    assert unmet(row, value, reading(row.file)) == row.places, "the sample is the default"
    assert not unmet(row, value, reading(row.file, f"{row.name}:={value}"))
