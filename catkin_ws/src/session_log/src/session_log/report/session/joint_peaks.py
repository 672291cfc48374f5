# SPDX-License-Identifier: BSD-3-Clause
"""What samples of the joint states may miss: the range of each joint and the largest RCM errors."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from session_log.config import ReportConfig
from session_log.mcap_file.bulk import Batch
from session_log.report.session.fast_topics import TOGETHER, largest_of_each
from session_log.report.session.joint_tables import by_names
from session_log.report.session.kinematics import ModelUnfit
from session_log.report.session.session_data import SessionData, Track
from session_log.report.session.shaft import rcm_errors


class JointPeaks:
    """Adds the extremes of all joint states to the data of a session.

    Args:
        data: Of the session.
        config: Settings of the report.
    """

    def __init__(self, data: SessionData, config: ReportConfig) -> None:
        self._data, self._config = data, config

    def take(self, batch: Batch, time: Track) -> None:
        """Take messages of one source, each list of joints for itself."""
        for names, mine, position in by_names(batch.lists("name"), batch.column("position")):
            self._take(time[mine], dict(zip(names, position.T, strict=True)))

    def _take(self, time: Track, q: Mapping[str, Track]) -> None:
        """Take positions by the names of their joints, at these times [s]; each of shape (n,)."""
        ranges = self._data.joint_ranges
        for name, values in q.items():
            known = values[np.isfinite(values)]
            low, high = ranges.get(name, (math.inf, -math.inf))
            ranges[name] = known.min(initial=low), known.max(initial=high)
        trocars = self._data.trocars[-TOGETHER:]  # a followed one has not moved more often since
        try:
            error = rcm_errors(time, q, self._data.urdf, trocars, self._config)
        except ModelUnfit:
            return
        peaks = largest_of_each(time, error, self._config.sample_period)
        self._data.rcm_peaks.extend(time[peaks], error[peaks])
