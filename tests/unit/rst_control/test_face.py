# SPDX-License-Identifier: BSD-3-Clause
"""The public names of the package."""

from __future__ import annotations

import subprocess
import sys

import pytest

import rst_control


def test_every_public_name_is_there_and_is_what_its_room_defines():
    assert set(rst_control.__all__) == set(rst_control._HOMES)
    assert 5 <= len(rst_control.__all__) <= 15
    for name in rst_control.__all__:
        assert getattr(rst_control, name).__module__.startswith("rst_control.")


def test_another_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = rst_control.no_such_name


def test_importing_the_package_loads_neither_compiler_nor_simulator():
    program = (
        "import sys, rst_control; print(sorted({'numba', 'pybullet', 'numpy'} & set(sys.modules)))"
    )
    command = [sys.executable, "-c", program]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "[]\n"
