# SPDX-License-Identifier: BSD-3-Clause
"""Takes the fast topics of a recording: sampled or whole, decoded many messages at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from session_log.mcap_file.bulk import Batch
from session_log.mcap_file.decoder import MissingField
from session_log.mcap_file.headers import starts_with_header
from session_log.report.session.session_data import Intervals, SessionData, Track
from session_log.report.session.stamp_clock import StampClock
from session_log.types import Message, MessageSource

TOGETHER = 1000  # messages decoded at once
_HEADER = 12  # [B] of sequence and stamp
_HEADS = np.dtype([("sequence", "<u4"), ("secs", "<u4"), ("nsecs", "<u4")])

Take = Callable[[Batch, Track], None]  # messages that fit, and their times (m,) [s]


class FastTopic:
    """Messages of one source that wait to be decoded.

    Args:
        source: Of the messages.
        clock: Of their stamps.
        take: What to do with them.
        data: Where misfits are counted.
        origin: Log time of the session's first message [ns].
        period: Between two samples [s]; zero: take all.
    """

    def __init__(
        self,
        source: MessageSource,
        clock: StampClock,
        take: Take,
        data: SessionData,
        origin: int,
        period: float,
    ) -> None:
        self._source, self._take, self._data, self._origin = source, take, data, origin
        self._clock = clock
        self._period, self._due = round(period * 1e9), 0
        self._latest = 0  # [ns] log time of the message before
        self._payloads: list[bytes] = []
        self._arrivals: list[int] = []

    def add(self, message: Message) -> None:
        """Take one message, unless it is not due yet; begin anew where the clock was set back."""
        if message.log_time < self._latest:
            self._due = message.log_time
        self._latest = message.log_time
        if message.log_time < self._due:
            return
        self._due = max(self._due + self._period, message.log_time)
        self._payloads.append(message.data)
        self._arrivals.append(message.log_time)
        if len(self._payloads) >= TOGETHER:
            self.flush()

    def flush(self) -> None:
        """Decode what waits."""
        payloads, arrivals = self._payloads, np.array(self._arrivals, np.int64)
        self._payloads, self._arrivals = [], []
        if not payloads:
            return
        source = self._source
        batch = Batch(source.datatype, source.definition, payloads)
        if batch.unfit and not self._period:  # what is sampled is also taken whole
            self._data.undecodable[source.topic] += len(batch.unfit)
        if len(batch.unfit) == len(payloads):
            return
        try:
            times = self._clock.in_log_time(batch.column("header.stamp"), arrivals[batch.fit])
            self._take(batch, np.asarray((times - self._origin) * 1e-9, np.float64))
        except KeyError as error:
            self._data.missing_fields.add(str(MissingField(source, str(error.args[0]))))


def largest_of_each(time: Track, value: Track, period: float) -> NDArray[np.intp]:
    """Places of the largest finite value in each period [s]; time [s] and value of shape (n,)."""
    known = np.flatnonzero(np.isfinite(value))
    turn = np.floor(time / period)
    order = known[np.lexsort((value[known], turn[known]))]
    return np.sort(order[np.diff(turn[order], append=np.inf) != 0])


class LoopTopic:
    """Time between the messages of one source of a fast topic, by the stamps in their headers."""

    def __init__(self, source: MessageSource, loop: Intervals) -> None:
        self._loop = loop
        self._has_header = starts_with_header(source.definition)
        self._heads = bytearray()
        self._arrivals: list[int] = []
        self._sequences: list[int] = []
        self._last: tuple[int, int] | None = None  # sequence and time [ns] of the one before

    def add(self, message: Message) -> None:
        """Take one message."""
        self._heads += message.data[:_HEADER].ljust(_HEADER, b"\0")
        self._arrivals.append(message.log_time)
        self._sequences.append(message.sequence)
        if len(self._arrivals) >= TOGETHER:
            self.flush()

    def flush(self) -> None:
        """Take the intervals of what waits; a lost message makes no late cycle."""
        times = np.array(self._arrivals, np.int64)  # [ns]
        sequences = np.array(self._sequences, np.int64)
        if self._has_header:
            heads = np.frombuffer(bytes(self._heads), _HEADS)
            sequences = heads["sequence"].astype(np.int64)
            stamps = heads["secs"].astype(np.int64) * 1_000_000_000 + heads["nsecs"]
            times = np.where(stamps > 0, stamps, times)
        self._heads, self._arrivals, self._sequences = bytearray(), [], []
        if self._last is not None:
            sequences = np.concatenate([[self._last[0]], sequences])
            times = np.concatenate([[self._last[1]], times])
        if len(times):
            self._last = int(sequences[-1]), int(times[-1])
        follows = np.diff(sequences) == 1
        self._loop.extend(np.diff(times)[follows] * 1e-9)
