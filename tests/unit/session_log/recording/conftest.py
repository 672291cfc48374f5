# SPDX-License-Identifier: BSD-3-Clause
"""Recorders of the file s.mcap that have not begun."""

import time
from dataclasses import replace

import pytest

from session_log.mcap_file.writer import SessionWriter
from session_log.recording.recorder import Recorder


@pytest.fixture
def make_recorder(tmp_path, recorder_config):
    """Makes one with some settings changed, another file, or other clocks."""

    def make(open_writer=lambda: SessionWriter(tmp_path / "s.mcap"), *clocks, **changes):
        return Recorder(
            open_writer, replace(recorder_config, **changes), *(clocks or (time.time_ns,))
        )

    return make


@pytest.fixture
def recorder(make_recorder):
    return make_recorder()
