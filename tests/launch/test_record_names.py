# SPDX-License-Identifier: BSD-3-Clause
"""record.launch gives the recorder the names of folders and sessions as they were typed."""

import pytest

from tests.launch.argument_places import ROOT
from tests.support.launch_reading import read

NAMES = ("0012", "1.10", "true", "1e3", "0", "False", "first_trial", "o'brien 2")


def asked(file, *words):
    """Folder and name of the session that the recorder is asked for."""
    found = read([str(ROOT / "launch" / file), *words]).parameters
    return found["/recorder/folder"], found["/recorder/name"]


@pytest.mark.parametrize("name", NAMES)
def test_names_arrive_as_typed_and_that_of_a_folder_instead_of_the_two_others(name):
    assert asked("record.launch", f"session:={name}") == ("", name)
    assert asked("record.launch", f"sessions:={name}", "session:=a") == (name, "a")
    words = (f"folder:={name}", "sessions:=/kept", "session:=a")
    assert asked("record.launch", *words) == (name, ".")


def test_without_names_the_recorder_chooses():
    assert asked("record.launch") == ("", "")


def test_a_name_given_to_the_system_arrives_as_typed():
    words = ("session:=1.10", "sessions:=0012")
    assert asked("system.launch", *words) == ("0012", "1.10")
