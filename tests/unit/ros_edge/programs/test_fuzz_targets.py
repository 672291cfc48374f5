# SPDX-License-Identifier: BSD-3-Clause
"""The targets of `make fuzz`, with random bytes and with every input that ever broke one."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.fuzz.targets import TARGETS

CRASHERS = sorted((Path(__file__).resolve().parents[3] / "data" / "crashers").glob("*/*"))


@pytest.mark.parametrize("name", TARGETS)
def test_random_bytes_break_nothing(name):
    @given(st.binary(max_size=120))
    def try_it(data):
        TARGETS[name](data)

    try_it()


@pytest.mark.parametrize("file", CRASHERS, ids=lambda file: f"{file.parent.name}/{file.name[:20]}")
def test_what_once_broke_a_target_does_so_no_more(file):
    TARGETS[file.parent.name](file.read_bytes())
