# SPDX-License-Identifier: BSD-3-Clause
"""Whether the stamps of a source are of the recorder's clock, and what to take where they are not.

A simulated clock begins at zero, and the clocks of two hosts may differ.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from session_log.types import MessageSource

APART = 3.0  # [s] between a stamp and its arrival; more is another clock
NEAR = 0.1  # [s] between them at the least, in a stretch; on one host it is below 0.04
MANY = 20  # messages: not all of them were late
LONG = 10.0  # [s] of a stretch of many messages: no pause of the recorder makes all of it late

Nanoseconds = NDArray[np.int64]
Seconds = NDArray[np.float64]


class StampClock:
    """The clock behind the stamps of one source; a clock may be set while it is recorded.

    Args:
        source: Of the messages.
        lags: By topic, the largest from stamp to arrival [s]; those of another clock are added.
    """

    def __init__(self, source: MessageSource, lags: dict[str, float]) -> None:
        self._source, self._lags = source, lags
        self._offset = 0.0  # [s] smallest lag of the stretch that is most off
        self._count, self._smallest = 0, math.inf  # of the present stretch; lag [s]
        self._begin = 0  # [ns] of that stretch
        self._last = 0.0, 0.0, True  # of a message: sent and came [s], and whether it was far off
        self._held_until = -math.inf  # [s] what came until then was only late

    @property
    def offset(self) -> tuple[str, float] | None:
        """The topic, and by how much its stamps are off the recorder's clock [s]; None: hardly."""
        last = self._smallest if self._count >= MANY else 0.0
        offset = max(self._offset, last, key=abs)
        return (self._source.topic, offset) if abs(offset) > NEAR else None

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
        is_set = sent != 0
        lag = np.where(is_set, arrivals - sent, 0)  # [ns]
        times = np.asarray(arrivals * 1e-9, np.float64)
        is_other = self._is_other(lag * 1e-9, times)
        if not self._source.is_latched:  # which may have been sent long before
            self._note_other(lag[is_other] * 1e-9)
            is_near = is_set & (np.abs(lag) <= APART * 1e9)
            self._note_near(lag[is_near] * 1e-9, arrivals[is_near])
        return np.where(stamps == 0, arrivals, np.where(is_other, stamps + lag, stamps))

    def _is_other(self, lag: Seconds, arrivals: Seconds) -> NDArray[np.bool_]:
        """Whether another clock stamped messages with these lags [s].

        A few between messages that are near were only late. So were those that came at once behind
        a pause, though they were sent in it: a link or a recorder held them up.
        """
        sent, far = arrivals - lag, np.abs(lag) > APART
        last_sent, last_arrival, was_far = self._last
        went, came = np.diff(sent, prepend=last_sent), np.diff(arrivals, prepend=last_arrival)
        begins = far & ~np.concatenate(([was_far], far[:-1]))
        is_late = far & (arrivals <= self._held_until)
        for begin in np.flatnonzero(begins & (went >= 0.0) & (went < 0.5 * came)).tolist():
            self._held_until = float(arrivals[begin]) + APART
            is_late[begin:] |= arrivals[begin:] <= self._held_until
        for begin, end in pairwise((np.flatnonzero(np.diff(far)) + 1).tolist()):
            if end - begin < MANY:
                is_late[begin:end] = True
        self._last = float(sent[-1]), float(arrivals[-1]), bool(far[-1])
        return far & ~is_late

    def _note_other(self, lag: Seconds) -> None:
        if len(lag):
            topic, most = self._source.topic, float(np.median(lag))
            self._lags[topic] = max(self._lags.get(topic, 0.0), most, key=abs)

    def _note_near(self, lag: Seconds, arrivals: Nanoseconds) -> None:
        """Take the smallest lag of each stretch; all of a stretch is off where a clock is."""
        for first in range(0, len(lag), MANY):
            part, times = lag[first : first + MANY], arrivals[first : first + MANY].tolist()
            self._begin = self._begin if self._count else times[0]
            self._count += len(part)
            self._smallest = min(self._smallest, float(part.min()))
            if self._count >= MANY and abs(times[-1] - self._begin) >= LONG * 1e9:
                self._offset = max(self._offset, self._smallest, key=abs)
                self._count, self._smallest = 0, math.inf
