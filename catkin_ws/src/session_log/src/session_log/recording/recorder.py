# SPDX-License-Identifier: BSD-3-Clause
"""Takes messages from many threads and writes them from one, so that nothing is lost unsaid."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from session_log.config import RecorderConfig
from session_log.errors import RecordingFailed
from session_log.mcap_file.headers import read_header, starts_with_header
from session_log.mcap_file.writer import SessionWriter
from session_log.types import Message, MessageSource

MOST_CHANNELS = 65_535  # that a file can hold
MOST_PUBLISHERS = 64  # of one topic with a channel each
MANY_PUBLISHERS = f"more than {MOST_PUBLISHERS} nodes"  # publisher of a topic's shared channel
BATCH = 5000  # entries written between two commits; bounds the memory of one commit


@dataclass
class TopicTally:
    """What one source has sent; changed only under the recorder's lock."""

    source: MessageSource
    has_header: bool
    received: int = 0
    dropped: int = 0  # because too much was waiting for the disk
    missed: int = 0  # gaps in the publisher's own header.seq: never arrived here
    last_seq: int | None = None
    is_refused: bool = False  # a file has no more channels


@dataclass(frozen=True)
class Metadata:
    """Named facts that wait to be written."""

    name: str
    values: Mapping[str, str]


@dataclass(frozen=True)
class RecorderStatus:
    """What diagnostics and acknowledgement need to know."""

    path: str  # empty until the file exists
    error: str  # why nothing, or not all, is being recorded now; empty when all is
    size: int  # [B] of the file
    received: int
    written: int
    dropped: int
    missed: int
    waiting: int  # messages
    written_until: int  # [ns] everything received before this is in the file
    topics: int

    @property
    def is_recording(self) -> bool:
        """Whether the file exists and takes what is received."""
        return bool(self.path) and not self.error


class Recorder:
    """Owns the file: a bounded queue in front of one thread that writes.

    Args:
        open_writer: Creates the file; called again after `retry_period` while it fails.
        config: Limits and periods.
        clock: Wall time, of the stamps [ns].
        steady: Monotonic time, of periods and limits [s].
    """

    def __init__(
        self,
        open_writer: Callable[[], SessionWriter],
        config: RecorderConfig,
        clock: Callable[[], int],
        steady: Callable[[], float] = time.monotonic,
    ) -> None:
        self._open_writer, self._config, self._clock = open_writer, config, clock
        self._steady = steady
        self._lock = threading.Lock()
        self._queue: deque[Message | Metadata] = deque()
        self._waiting_bytes = 0
        self._tallies: dict[MessageSource, TopicTally] = {}
        self._writer: SessionWriter | None = None
        self._error = ""
        self._fault = ""  # an unexpected error; stays until the end
        self._in_flight = 0  # messages taken from the queue, not yet in the file
        self._written = 0
        self._written_until = 0
        self._next_sync = float("-inf")  # [s]
        self._progress = float("inf")  # [s] when the disk last took something, or had nothing to
        self._last_drop = float("-inf")  # [s]
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="session_writer", daemon=True)

    def start(self) -> None:
        """Begin to write."""
        self._progress = self._steady()
        self._thread.start()

    def register(self, source: MessageSource) -> TopicTally:
        """Announce a source; its messages are then offered with the returned tally.

        The first publishers of a topic have a channel each, all others share one: a script that
        calls `rostopic pub` again and again is a new node each time.
        """
        with self._lock:
            if source not in self._tallies:
                of_topic = sum(known.topic == source.topic for known in self._tallies)
                if of_topic >= MOST_PUBLISHERS:
                    source = replace(source, publisher=MANY_PUBLISHERS)
            return self._tallies.setdefault(source, self._new_tally(source))

    def offer(self, tally: TopicTally, data: bytes) -> bool:
        """Take one message as received now, never waiting for the disk; False if it was dropped."""
        with self._lock:
            tally.received += 1
            if tally.has_header:
                self._note_gap(tally, data)
            if tally.is_refused or self._is_full(len(data)):
                tally.dropped += 1
                self._last_drop = self._steady()
                return False
            self._waiting_bytes += len(data)
            self._queue.append(Message(tally.source, data, self._clock(), tally.received))
            return True

    def _new_tally(self, source: MessageSource) -> TopicTally:
        is_shared = source.publisher == MANY_PUBLISHERS
        has_header = starts_with_header(source.definition) and not is_shared
        return TopicTally(source, has_header, is_refused=len(self._tallies) >= MOST_CHANNELS)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Take named facts about the session."""
        with self._lock:
            self._queue.append(Metadata(name, dict(values)))

    def status(self) -> RecorderStatus:
        """Describe the present state."""
        with self._lock:
            return RecorderStatus(
                path=str(self._writer.path) if self._writer else "",
                error=self._fault or self._error or self._loss(),
                size=self._writer.committed if self._writer else 0,
                received=sum(t.received for t in self._tallies.values()),
                written=self._written,
                dropped=sum(t.dropped for t in self._tallies.values()),
                missed=sum(t.missed for t in self._tallies.values()),
                waiting=len(self._queue),
                written_until=self._written_until,
                topics=len({t.source.topic for t in self._tallies.values()}),
            )

    def tallies(self) -> list[TopicTally]:
        """List every source that was registered."""
        with self._lock:
            return list(self._tallies.values())

    def close(self) -> str:
        """Write what waits and close the file; returns the error that prevented it, or nothing."""
        self._closing.set()
        if self._thread.ident is not None:
            self._thread.join()
        return self._fault or self._error

    def _loss(self) -> str:
        """What is wrong although no attempt to write has failed."""
        now, allowed = self._steady(), self._config.stall_time
        if now - self._progress > allowed:
            return f"the disk has taken nothing for more than {allowed:g} s"
        if any(tally.is_refused for tally in self._tallies.values()):
            return f"more than {MOST_CHANNELS} topics: the others are not recorded"
        if now - self._last_drop <= allowed:
            return "messages are being dropped: the disk is too slow"
        return ""

    def _is_full(self, size: int) -> bool:
        too_many = len(self._queue) >= self._config.queue_messages
        return too_many or self._waiting_bytes + size > self._config.queue_size

    @staticmethod
    def _note_gap(tally: TopicTally, data: bytes) -> None:
        header = read_header(data)
        if header is None:
            return
        if tally.source.is_latched and tally.received <= 2:
            tally.last_seq = None  # the first was kept from before the connection
        if tally.last_seq is not None and header.sequence > tally.last_seq + 1:
            tally.missed += header.sequence - tally.last_seq - 1
        tally.last_seq = header.sequence

    def _run(self) -> None:
        while not self._closing.is_set():
            pause = self._config.retry_period if self._error else self._config.flush_period
            self._closing.wait(pause)
            self._attempt(self._write_waiting)
        self._attempt(self._write_waiting)
        why = self._error
        self._attempt(self._finish)
        if self._queue or self._in_flight or self._writer is None:
            unwritten = self._in_flight + sum(isinstance(e, Message) for e in self._queue)
            self._error = f"{self._error or why}; {unwritten} messages were not written"

    def _attempt(self, action: Callable[[], None]) -> None:
        try:
            action()
        except RecordingFailed as error:
            self._error = str(error)
        except Exception as error:  # top of the thread: the recorder must go on and say so
            self._fault = f"recorder failed: {type(error).__name__}: {error}"
        else:
            self._error = ""

    def _write_waiting(self) -> None:
        if self._writer is None:
            self._writer = self._open_writer()
        self._commit(self._writer)  # what a failed commit left, before anything new
        while True:
            batch, until = self._take()
            for entry in batch:
                self._write(self._writer, entry)
            self._commit(self._writer)
            if until:
                self._written_until = until
                break
        self._writer.check()  # whatever sync_period is
        self._sync_if_due(self._writer)

    def _take(self) -> tuple[list[Message | Metadata], int]:
        """Take a batch, and the time up to which it completes the record (0: more is waiting)."""
        with self._lock:
            if len(self._queue) <= BATCH:
                batch = list(self._queue)
                self._queue.clear()
                self._waiting_bytes = 0
                return batch, self._clock()
            batch = [self._queue.popleft() for _ in range(BATCH)]
            self._waiting_bytes -= sum(len(e.data) for e in batch if isinstance(e, Message))
            return batch, 0

    def _commit(self, writer: SessionWriter) -> None:
        writer.commit()
        self._count_written()
        self._progress = self._steady()

    def _count_written(self) -> None:
        self._written += self._in_flight
        self._in_flight = 0

    def _write(self, writer: SessionWriter, entry: Message | Metadata) -> None:
        if isinstance(entry, Message):
            writer.add(entry)
            self._in_flight += 1
        else:
            writer.add_metadata(entry.name, entry.values)

    def _sync_if_due(self, writer: SessionWriter) -> None:
        now = self._steady()
        if self._config.sync_period and now >= self._next_sync:
            writer.sync()  # if it fails, the next attempt tries again
            self._next_sync = now + self._config.sync_period

    def _finish(self) -> None:
        if self._writer is None:
            return
        losses: dict[str, tuple[int, int]] = {}
        for t in self._tallies.values():  # a publisher may have come again with another type
            if t.dropped or t.missed:
                name = f"{t.source.topic} from {t.source.publisher}"
                dropped, missed = losses.get(name, (0, 0))
                losses[name] = dropped + t.dropped, missed + t.missed
        if losses:
            words = {n: f"{lost[0]} dropped, {lost[1]} missed" for n, lost in losses.items()}
            self._writer.add_metadata("losses", words)
        self._writer.close()
        self._count_written()
