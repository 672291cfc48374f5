# SPDX-License-Identifier: BSD-3-Clause
"""The public names of the package."""

from __future__ import annotations

import subprocess
import sys

import pytest

import voice_assist


def test_every_public_name_is_there_and_is_what_its_room_defines():
    assert set(voice_assist.__all__) == set(voice_assist._HOMES)
    assert 5 <= len(voice_assist.__all__) <= 15
    for name in voice_assist.__all__:
        assert getattr(voice_assist, name).__module__.startswith("voice_assist.")


def test_another_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = voice_assist.no_such_name


def test_importing_the_package_loads_no_network():
    program = "import sys, voice_assist; print(sorted({'torch', 'numpy'} & set(sys.modules)))"
    command = [sys.executable, "-c", program]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "[]\n"
