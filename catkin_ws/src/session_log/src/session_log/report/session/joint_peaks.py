# SPDX-License-Identifier: BSD-3-Clause
"""What samples of the joint states may miss: the range of each joint and the largest RCM errors."""

from __future__ import annotations

import math

import numpy as np

from session_log.config import ReportConfig
from session_log.mcap_file.bulk import Batch
from session_log.report.session.fast_topics import TOGETHER, largest_of_each
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
        """Take messages of one source; those of several lists of joints are left to the samples."""
        position, names = batch.column("position"), _names(batch)
        if position.ndim != 2 or len(names) != position.shape[1]:
            return
        q = dict(zip(names, position.T, strict=True))
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


def _names(batch: Batch) -> tuple[str, ...]:
    """Names of the joints, where all messages have the same; else none."""
    try:
        columns = [batch.column(field) for field in batch.names if field.startswith("name[")]
    except KeyError:  # they differ in number
        return ()
    return tuple(c[0] for c in columns) if all((c == c[0]).all() for c in columns) else ()
