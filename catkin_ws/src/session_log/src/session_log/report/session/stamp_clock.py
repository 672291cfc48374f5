# SPDX-License-Identifier: BSD-3-Clause
"""Whether the stamps of a source are of the recorder's clock, and what to take where they are not.

A simulated clock begins at zero, and the clocks of two hosts may differ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
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
Flags = NDArray[np.bool_]


@dataclass
class _Stretch:
    """Lags of messages that came one after the other."""

    begin: int = 0  # [ns] when the first came
    count: int = 0
    ahead: int = 0  # how many of them were stamped more than NEAR after they came
    smallest: float = math.inf  # [s]
    smallest_other: float = math.inf  # [s] of those that were not so far ahead

    def add(self, lag: Seconds, begin: int) -> None:
        """Take lags [s], shape (n,), the first of which came at this time [ns]."""
        self.begin = self.begin if self.count else begin
        is_ahead = lag < -NEAR
        self.count += len(lag)
        self.ahead += int(np.count_nonzero(is_ahead))
        self.smallest = min(self.smallest, float(lag.min()))
        self.smallest_other = min(self.smallest_other, float(lag[~is_ahead].min(initial=math.inf)))

    @property
    def offset(self) -> float:
        """Smallest lag [s]; a few odd stamps ahead make no clock that is ahead."""
        return self.smallest if 2 * self.ahead > self.count else self.smallest_other


class StampClock:
    """The clock behind the stamps of one source; a clock may be set while it is recorded.

    Args:
        source: Of the messages.
        lags: By topic, the largest from stamp to arrival [s]; those of another clock are added.
    """

    def __init__(self, source: MessageSource, lags: dict[str, float]) -> None:
        self._source, self._lags = source, lags
        self._offset = 0.0  # [s] smallest lag of the stretch that is most off
        self._stretch = _Stretch()  # the present one
        self._last = 0.0, 0.0  # [s] when the message before was sent, and when it came
        self._far: int | None = None  # how many just before were far off; None: nothing came yet
        self._held_until = -math.inf  # [s] what came until then was only late

    @property
    def offset(self) -> tuple[str, float] | None:
        """The topic, and by how much its stamps are off the recorder's clock [s]; None: hardly."""
        last = self._stretch.offset if self._stretch.count >= MANY else 0.0
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
        is_other, is_open = self._is_other(lag * 1e-9, times)
        if not self._source.is_latched:  # which may have been sent long before
            self._note_other(lag[is_other & ~is_open] * 1e-9)
            is_near = is_set & (np.abs(lag) <= APART * 1e9)
            self._note_near(lag[is_near] * 1e-9, arrivals[is_near])
        return np.where(stamps == 0, arrivals, np.where(is_other, stamps + lag, stamps))

    def _is_other(self, lag: Seconds, arrivals: Seconds) -> tuple[Flags, Flags]:
        """Whether another clock stamped messages with these lags [s], and where that is open.

        A few between messages that are near were only late. So were those that came at once behind
        a pause, though they were sent in it: a link or a recorder held them up.
        """
        sent, far = arrivals - lag, np.abs(lag) > APART
        last_sent, last_arrival = self._last
        went, came = np.diff(sent, prepend=last_sent), np.diff(arrivals, prepend=last_arrival)
        begins = far & ~np.concatenate(([self._far != 0], far[:-1]))
        is_late = far & (arrivals <= self._held_until)
        for begin in np.flatnonzero(begins & (went >= 0.0) & (went < 0.5 * came)).tolist():
            self._held_until = float(arrivals[begin]) + APART
            is_late[begin:] |= arrivals[begin:] <= self._held_until
        is_few, is_open = self._are_few(far)
        self._last = float(sent[-1]), float(arrivals[-1])
        return far & ~(is_late | is_few), is_open

    def _are_few(self, far: Flags) -> tuple[Flags, Flags]:
        """Which are a few far ones between near ones, and which may be.

        Of a few at the end of many messages, or before the first near one of all, nobody knows.
        """
        is_few, is_open = np.zeros(len(far), bool), np.zeros(len(far), bool)
        before, count = self._far or 0, len(far)
        for begin, end in pairwise((0, *(np.flatnonzero(np.diff(far)) + 1).tolist(), count)):
            is_inside = begin > 0 and end < count
            length = end - begin + (0 if begin else before)
            if far[begin] and length < MANY and (is_inside or count >= MANY):
                ends_unknown = end == count or (begin == 0 and self._far is None)
                (is_open if ends_unknown else is_few)[begin:end] = True
        near = np.flatnonzero(~far)
        self._far = count - 1 - int(near[-1]) if len(near) else before + count
        return is_few, is_open

    def _note_other(self, lag: Seconds) -> None:
        if len(lag):
            topic, most = self._source.topic, float(np.median(lag))
            self._lags[topic] = max(self._lags.get(topic, 0.0), most, key=abs)

    def _note_near(self, lag: Seconds, arrivals: Nanoseconds) -> None:
        """Take the smallest lag of each stretch; all of a stretch is off where a clock is."""
        for first in range(0, len(lag), MANY):
            times = arrivals[first : first + MANY].tolist()
            stretch = self._stretch
            stretch.add(lag[first : first + MANY], times[0])
            if stretch.count >= MANY and abs(times[-1] - stretch.begin) >= LONG * 1e9:
                self._offset = max(self._offset, stretch.offset, key=abs)
                self._stretch = _Stretch()
