# SPDX-License-Identifier: BSD-3-Clause
"""Whether the stamps of a source are of the recorder's clock, and what to take where they are not.

A simulated clock begins at zero, and the clocks of two hosts may differ.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from session_log.types import MessageSource

APART = 3.0  # [s] between a stamp and its arrival; more is another clock
NEAR = 0.1  # [s] between them at the least, of many messages; on one host it is below 0.04
MANY = 20  # messages: not all of them were late

Nanoseconds = NDArray[np.int64]


class StampClock:
    """The clock behind the stamps of one source; the first of them decide whose it is.

    Args:
        source: Of the messages.
        lags: By topic, from stamp to arrival [s]; those of another clock are added.
    """

    def __init__(self, source: MessageSource, lags: dict[str, float]) -> None:
        self._source, self._lags = source, lags
        self._is_other: bool | None = None  # unknown before the first stamp
        self._count, self._smallest = 0, math.inf  # of stamps; [s] from one to its arrival

    @property
    def offset(self) -> tuple[str, float] | None:
        """The topic, and by how much its stamps are off the recorder's clock [s]; None: hardly."""
        is_known = self._count >= MANY and not (self._is_other or self._source.is_latched)
        is_off = is_known and abs(self._smallest) > NEAR
        return (self._source.topic, self._smallest) if is_off else None

    def in_log_time(
        self, stamps: Nanoseconds, arrivals: Nanoseconds, sent: Nanoseconds | None = None
    ) -> Nanoseconds:
        """Stamps by the recorder's clock [ns], shape (n,); an arrival where one was not set.

        Args:
            stamps: As they were recorded [ns]. Shape (n,).
            arrivals: Log times of the messages [ns]. Shape (n,) or (1,).
            sent: When they were sent, by the stamps' clock [ns], if not at those. As arrivals.
        """
        sent = stamps if sent is None else sent
        lag = (arrivals - sent)[sent != 0]
        if len(lag):
            self._count += len(lag)
            self._smallest = min(self._smallest, float(lag.min()) * 1e-9)
        if self._is_other is None and len(lag):
            self._is_other = self._judge(float(np.median(lag)) * 1e-9)
        times = stamps + (arrivals - sent) if self._is_other else stamps
        return np.where(stamps == 0, arrivals, times)

    def _judge(self, lag: float) -> bool:
        is_other = abs(lag) > APART
        if is_other and not self._source.is_latched:  # which may have been sent long before
            self._lags[self._source.topic] = lag
        return is_other
