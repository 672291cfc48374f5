# SPDX-License-Identifier: BSD-3-Clause
"""The public names of the packages."""

import importlib
import subprocess
import sys

import pytest

# What takes time to load, or compiles or simulates
HEAVY = {"numba", "pybullet", "numpy", "torch", "matplotlib", "pyarrow", "mcap"}
PACKAGES = ("rst_control", "voice_assist", "session_log")


@pytest.mark.parametrize("name", PACKAGES)
def test_every_public_name_is_what_its_room_defines_and_there_is_no_other(name):
    package = importlib.import_module(name)
    assert set(package.__all__) == set(package._HOMES)
    assert 5 <= len(package.__all__) <= 15
    for public in package.__all__:
        assert getattr(package, public).__module__.startswith(f"{name}.")
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = package.no_such_name


def test_importing_the_packages_loads_nothing_heavy():
    program = f"import sys, {', '.join(PACKAGES)}; print({HEAVY} & set(sys.modules))"
    command = [sys.executable, "-c", program]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "set()\n"
