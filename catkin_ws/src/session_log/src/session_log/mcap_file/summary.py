# SPDX-License-Identifier: BSD-3-Clause
"""Counts what a recording holds: topics, rates, what is missing."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from datetime import datetime

from session_log.mcap_file.condition import FileCondition
from session_log.mcap_file.reader import SessionReader
from session_log.types import Message, MessageSource, TopicCount

ACCOUNT = "recovered"  # metadata of a copy: what it was made from
CLOCK_STEP = 100_000_000  # [ns] back; less is no clock that was set
LONGEST_SILENCE = 5_000_000_000  # [ns] a session is never so quiet: its state comes at 50 Hz


@dataclass(frozen=True)
class ClockStep:
    """The recorder's clock was set during the recording; forward looks like a silence."""

    before: int  # [ns] log time of the last message before it
    after: int  # [ns] of the next one

    def __str__(self) -> str:
        time = datetime.fromtimestamp(self.before * 1e-9).astimezone()
        seconds = (self.after - self.before) * 1e-9
        where = f"{abs(seconds):.1f} s at {time:%Y-%m-%d %H:%M:%S %Z}"
        if seconds < 0.0:
            return f"the clock was set back by {where}"
        return f"the clock was set forward by {where}, or nothing was recorded meanwhile"


@dataclass
class RecordingSummary:
    """What a recording holds."""

    condition: FileCondition
    topics: dict[str, TopicCount] = field(default_factory=dict)
    clock_steps: list[ClockStep] = field(default_factory=list)

    @property
    def messages(self) -> int:
        """Number of readable messages."""
        return sum(topic.messages for topic in self.topics.values())

    @property
    def missing(self) -> int:
        """Number of messages that were received and are not in the file."""
        return sum(topic.missing for topic in self.topics.values())

    @property
    def losses(self) -> dict[str, str]:
        """What the recorder itself says was lost, by topic and publisher."""
        return self.condition.latest("losses")

    @property
    def dropped(self) -> dict[str, str]:
        """Those that reached the recorder and are not in the file. Others never came to it."""
        return {name: loss for name, loss in self.losses.items() if not loss.startswith("0 ")}

    @property
    def cuts(self) -> list[str]:
        """What was lost before this file was copied from another one, in words; empty: nothing."""
        return [words for account in self._accounts if (words := _cut(account))]

    def lacks(self, topics: Collection[str]) -> bool:
        """Whether messages of these topics may be lost: by damage, here or before, or dropped.

        What was dropped shows in the numbers of the messages that were read, if the recorder was
        killed before it could say so.

        A recording that was only not closed has all that it had received but the last moment.
        """
        condition = self.condition
        is_damaged = bool(condition.damage) or condition.checksum == "wrong"
        dropped = any(name.partition(" from ")[0] in topics for name in self.dropped)
        gaps = any(count.missing for name, count in self.topics.items() if name in topics)
        return is_damaged or dropped or gaps or any(_lost(account) for account in self._accounts)

    @property
    def _accounts(self) -> list[dict[str, str]]:
        """What copies say of the files they were made from."""
        return [values for name, values in self.condition.metadata if name == ACCOUNT]

    @property
    def start(self) -> int:
        """Time of the first message [ns]; zero for an empty file."""
        return min((t.first for t in self.topics.values()), default=0)

    @property
    def duration(self) -> float:
        """From the first message to the last [s]."""
        last = max((t.last for t in self.topics.values()), default=0)
        return (last - self.start) * 1e-9


@dataclass(slots=True)
class _SourceCount:
    """What one source has in the file."""

    topic: TopicCount
    sequence: int = 0  # of its latest message


class MessageCounter:
    """Counts the messages of a recording as they pass.

    Args:
        reader: The recording.
    """

    def __init__(self, reader: SessionReader) -> None:
        self._reader = reader
        self.topics: dict[str, TopicCount] = {}
        self.clock_steps: list[ClockStep] = []
        self._sources: dict[MessageSource, _SourceCount] = {}
        self._now = 0  # [ns] log time of the latest message
        self._set_back = 0  # [ns] by which the clock was, in all

    def add(self, message: Message) -> None:
        """Count one message."""
        source, data, log_time, sequence, _ = message
        before, self._now = self._now, log_time
        is_odd = before and not -CLOCK_STEP <= log_time - before <= LONGEST_SILENCE
        if is_odd and self._reader.condition.is_numbered:
            self.clock_steps.append(ClockStep(before, log_time))
            self._set_back += max(before - log_time, 0)
        log_time += self._set_back
        known = self._sources.get(source) or self._new(source, log_time)
        if sequence > known.sequence + 1:
            known.topic.missing += sequence - known.sequence - 1
        known.sequence = sequence
        count = known.topic
        count.messages += 1
        count.size += len(data)
        if log_time > count.last:
            count.last = log_time
        elif log_time < count.first:
            count.first = log_time

    def _new(self, source: MessageSource, log_time: int) -> _SourceCount:
        count = self.topics.setdefault(source.topic, TopicCount(source.datatype, first=log_time))
        count.publishers.add(source.publisher)
        self._sources[source] = _SourceCount(count)
        return self._sources[source]

    def summary(self) -> RecordingSummary:
        """Sum up what has passed."""
        if not self._reader.condition.is_numbered:
            for count in self.topics.values():
                count.missing = 0
        return RecordingSummary(self._reader.condition, self.topics, self.clock_steps)

    def messages(self) -> Iterator[Message]:
        """Read all messages, count them and pass them on."""
        for message in self._reader.messages():
            self.add(message)
            yield message


def read_summary(reader: SessionReader) -> RecordingSummary:
    """Read through a recording and count."""
    counter = MessageCounter(reader)
    for _ in counter.messages():
        pass
    return counter.summary()


def _cut(account: dict[str, str]) -> str:
    """What a copy says of losses in the file it was made from; empty: that file was sound."""
    was_closed = account.get("was_closed") == "True"
    troubles = [*([] if was_closed else ["was not closed"]), *_lost(account)]
    return f"copied from {account.get('from')}, which {' and '.join(troubles)}" if troubles else ""


def _lost(account: dict[str, str]) -> list[str]:
    troubles = []
    unreadable = account.get("unreadable_bytes", "0")
    if unreadable != "0" or account.get("damage"):
        troubles.append(f"lost {unreadable} bytes")
    if account.get("checksum") == "wrong":  # older copies do not say
        troubles.append("had a wrong checksum")
    return troubles
