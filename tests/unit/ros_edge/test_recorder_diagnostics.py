# SPDX-License-Identifier: BSD-3-Clause
"""What the recorder says of its file in /diagnostics."""

from types import SimpleNamespace

import pytest
from diagnostic_updater import DiagnosticStatusWrapper

from session_log.recording.recorder import RecorderStatus
from session_log.ros import diagnostics as diagnostics_module
from session_log.ros.diagnostics import RecorderDiagnostics


class FakeRecorder:
    """Writes to the file that a test names."""

    path = ""

    def status(self):
        return RecorderStatus(self.path, "", *(0,) * 8)

    def tallies(self):
        return []


@pytest.fixture
def clock(monkeypatch):
    clock = SimpleNamespace(now=100.0, monotonic=lambda: clock.now)
    monkeypatch.setattr(diagnostics_module, "time", clock)
    return clock


def test_how_long_a_file_has_been_recorded_for_counts_from_its_begin(monkeypatch, clock):
    updater = SimpleNamespace(setHardwareID=lambda _: None, add=lambda *_: None)
    monkeypatch.setattr(diagnostics_module.diagnostic_updater, "Updater", lambda: updater)
    recorder = FakeRecorder()
    diagnostics = RecorderDiagnostics(recorder, SimpleNamespace(low_space=0))
    said = []
    for path in ("", "/a.mcap", "/a.mcap", "/b.mcap", "/b.mcap"):
        recorder.path = path
        values = diagnostics._fill(DiagnosticStatusWrapper()).values
        said += [pair.value for pair in values if pair.key == "recorded for [s]"]
        clock.now += 2.0
    assert [float(value) for value in said] == [0.0, 0.0, 2.0, 0.0, 2.0]
