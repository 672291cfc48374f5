# SPDX-License-Identifier: BSD-3-Clause
"""Says in /diagnostics what is being recorded, and what is not."""

from __future__ import annotations

import os
import time

import diagnostic_updater
from diagnostic_msgs.msg import DiagnosticStatus

from session_log.config import RecorderConfig
from session_log.recording.recorder import Recorder, RecorderStatus


class RecorderDiagnostics:
    """Fills one diagnostic status from the recorder's."""

    def __init__(self, recorder: Recorder, config: RecorderConfig) -> None:
        self._recorder, self._config = recorder, config
        self._file, self._began = "", 0.0  # that is recorded, and since when [s] of a steady clock
        self.problem = ""  # of discovery or of the topics that were waited for
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID("session_log")
        self._updater.add("recording", self._fill)

    def publish(self) -> None:
        """Publish now; the node keeps the period, by a clock that no simulation sets."""
        self._updater.force_update()

    def _fill(self, stat: diagnostic_updater.DiagnosticStatusWrapper) -> object:
        status = self._recorder.status()
        stat.summary(*self._summary(status))
        stat.add("file", status.path)
        stat.add("recorded for [s]", round(self._recorded_for(status.path), 1))
        stat.add("size [B]", status.size)
        stat.add("topics", status.topics)
        stat.add("messages received", status.received)
        stat.add("messages written", status.written)
        stat.add("messages waiting", status.waiting)
        stat.add("messages dropped", status.dropped)
        stat.add("messages missed", status.missed)
        stat.add("free space [B]", free_space(status.path))
        for tally in self._recorder.tallies():
            if tally.dropped or tally.missed:
                words = f"{tally.dropped} dropped, {tally.missed} missed"
                stat.add(f"loss on {tally.source.topic} from {tally.source.publisher}", words)
        return stat

    def _recorded_for(self, path: str) -> float:
        """How long this file has been seen here [s]; zero: there is none."""
        now = time.monotonic()
        if path != self._file:
            self._file, self._began = path, now
        return now - self._began if path else 0.0

    def _summary(self, status: RecorderStatus) -> tuple[bytes, str]:
        if not status.is_recording:
            return DiagnosticStatus.ERROR, f"NOT RECORDING: {status.error or 'starting'}"
        if status.dropped:
            return (
                DiagnosticStatus.ERROR,
                f"{status.dropped} messages dropped: the disk is too slow",
            )
        if self.problem:
            return DiagnosticStatus.ERROR, self.problem
        if free_space(status.path) < self._config.low_space:
            return DiagnosticStatus.WARN, "little disk space left"
        if status.missed:
            return DiagnosticStatus.WARN, f"{status.missed} messages lost before they came here"
        return DiagnosticStatus.OK, "recording"


def free_space(path: str) -> int:
    """Free space of the disk that holds a file [B]; zero if it is unknown."""
    try:
        info = os.statvfs(path)
    except OSError:
        return 0
    return info.f_bavail * info.f_frsize
