# SPDX-License-Identifier: BSD-3-Clause
"""The public names of the package."""

import subprocess
import sys

import pytest

import session_log


def test_every_public_name_is_there_and_is_what_its_room_defines():
    assert set(session_log.__all__) == set(session_log._HOMES)
    assert 5 <= len(session_log.__all__) <= 15
    for name in session_log.__all__:
        assert getattr(session_log, name).__module__.startswith("session_log.")


def test_another_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = session_log.no_such_name


def test_importing_the_package_loads_nothing_that_takes_time():
    heavy = "{'numpy', 'matplotlib', 'pyarrow', 'mcap'}"
    program = f"import sys, session_log; print(sorted({heavy} & set(sys.modules)))"
    command = [sys.executable, "-c", program]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "[]\n"
