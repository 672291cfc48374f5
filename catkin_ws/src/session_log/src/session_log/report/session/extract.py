# SPDX-License-Identifier: BSD-3-Clause
"""Reads a recording once and takes from it what the report needs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from session_log.config import ReportConfig
from session_log.mcap_file.decoder import Decoder, MissingField, Undecodable
from session_log.mcap_file.headers import read_header, starts_with_header
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import MessageCounter, RecordingSummary
from session_log.report.session.session_data import (
    IntendedPhrase,
    Intervals,
    NodeHealth,
    RecordedEvent,
    RecordedPicture,
    RecordedTrocar,
    RecordedUtterance,
    SampledTable,
    SessionData,
    Span,
)
from session_log.types import Message, MessageSource

MOVING = ("moving", "stopping")
URDF_TOPIC = "/robot_description"
FULL_SCALE = 32767.0
QUIETEST = -90.0  # [dBFS] digital silence is drawn here


def extract(reader: SessionReader, config: ReportConfig) -> SessionData:
    """Take the tables, events and pictures of a session in one pass."""
    counter = MessageCounter()
    data = SessionData(RecordingSummary(reader.condition, counter.topics))
    extractor = _Extractor(data, config)
    for message in counter.counting(reader.messages()):
        extractor.add(message)
    data.recording = counter.summary(reader.condition)
    extractor.finish()
    return data


class _Words:
    """Turns a word that is said again and again into spans."""

    def __init__(self, spans: list[Span]) -> None:
        self._spans = spans
        self._word: str | None = None
        self._since = 0.0

    def say(self, time: float, word: str) -> None:
        if word != self._word:
            self.end(time)
            self._word, self._since = word, time

    def end(self, time: float) -> None:
        if self._word is not None and time > self._since:
            self._spans.append(Span(self._since, time, self._word))


class _Extractor:
    def __init__(self, data: SessionData, config: ReportConfig) -> None:
        topics = config.topics
        self._data, self._config = data, config
        self._decoder = Decoder()
        self._origin: int | None = None  # [ns]
        self._now = 0.0  # [s] log time of the present message
        self._due: dict[str, float] = {}
        self._has_header: dict[MessageSource, bool] = {}
        self._previous: dict[MessageSource, tuple[int, float]] = {}
        self._health: dict[str, NodeHealth] = {}
        self._picture_step = self._picture_count = 0
        self._modes, self._states = _Words(data.modes), _Words(data.states)
        self._phases = _Words(data.phases)
        self._loops = {t: Intervals(t) for t in (topics.joint_states, topics.set_points)}
        self._slow: dict[str, Callable[[Any], None]] = {
            topics.utterance: self._utterance,
            topics.mode: self._mode,
            topics.audio: self._audio,
            topics.event: self._event,
            topics.state: self._state,
            topics.picture: self._picture,
            topics.diagnostics: self._diagnostics,
            topics.intended: self._intended,
            topics.trocar: self._trocar,
            URDF_TOPIC: self._urdf,
        }
        self._fast: dict[str, Callable[[Any], None]] = {
            topics.tension: self._tension,
            topics.joint_states: self._joints,
        }

    def add(self, message: Message) -> None:
        """Take what matters of one message."""
        if self._origin is None:
            self._origin = message.log_time
        self._now = (message.log_time - self._origin) * 1e-9
        topic = message.source.topic
        if topic in self._loops:
            self._interval(self._loops[topic], message)
        take = self._slow.get(topic)
        if take is None and self._is_due(topic):
            take = self._fast.get(topic)
        if take is not None:
            self._decode(message, take)

    def finish(self) -> None:
        """Close what is open."""
        for words in (self._modes, self._states, self._phases):
            words.end(self._now)
        self._data.health = sorted(self._health.values(), key=lambda h: h.name)
        self._data.loops = [loop for loop in self._loops.values() if loop.length]

    def _decode(self, message: Message, take: Callable[[Any], None]) -> None:
        topic = message.source.topic
        try:
            self._decoder.read(message, take)
        except MissingField as error:
            self._data.missing_fields.add(str(error))
        except (Undecodable, AttributeError, ValueError, IndexError):
            self._data.undecodable[topic] = self._data.undecodable.get(topic, 0) + 1

    def _is_due(self, topic: str) -> bool:
        if topic not in self._fast:
            return False
        due = self._due.get(topic, -math.inf)
        if self._now < due:
            return False
        self._due[topic] = max(due + self._config.sample_period, self._now)
        return True

    def _interval(self, loop: Intervals, message: Message) -> None:
        source = message.source
        if source not in self._has_header:
            self._has_header[source] = starts_with_header(source.definition)
        header = read_header(message.data) if self._has_header[source] else None
        time = self._relative(header.stamp) if header and header.stamp else self._now
        sequence = header.sequence if header else message.sequence
        before = self._previous.get(source)
        self._previous[source] = (sequence, time)
        if before is not None and sequence == before[0] + 1:  # a lost message is no late cycle
            loop.time.append(time)
            loop.length.append(time - before[1])

    def _relative(self, stamp: int) -> float:
        return (stamp - (self._origin or 0)) * 1e-9

    def _time(self, stamp: Any) -> float:
        """Time of a stamp [s]; that of its arrival if it was not set."""
        nanoseconds = stamp.secs * 1_000_000_000 + stamp.nsecs
        return self._relative(nanoseconds) if nanoseconds else self._now

    def _utterance(self, m: Any) -> None:
        wer = dict(zip(m.phrases, m.wer, strict=False))
        self._data.phrases = tuple(m.phrases) or self._data.phrases
        self._data.heard.append(
            RecordedUtterance(
                speech_start=self._time(m.speech_start),
                speech_end=self._time(m.speech_end),
                decision=self._time(m.decision),
                transcript=m.transcript,
                command=m.command,
                reason=m.reason,
                nearest_command=m.nearest_command,
                wer=float(wer.get(m.command or m.nearest_command, math.nan)),
                confidence=float(m.confidence),
                mode=m.mode,
                decided_by=m.decided_by,
                is_partial=bool(m.is_partial),
            )
        )

    def _intended(self, m: Any) -> None:
        self._data.intended.append(IntendedPhrase(self._now, m.data))

    def _trocar(self, m: Any) -> None:
        position = (m.point.x, m.point.y, m.point.z)
        self._data.trocars.append(RecordedTrocar(self._now, position, m.header.frame_id))

    def _mode(self, m: Any) -> None:
        self._modes.say(max(self._time(m.header.stamp), 0.0), m.mode)

    def _event(self, m: Any) -> None:
        self._data.events.append(
            RecordedEvent(self._time(m.header.stamp), m.kind, m.command, m.message)
        )

    def _state(self, m: Any) -> None:
        time = self._time(m.header.stamp)
        self._states.say(time, m.state)
        self._phases.say(time, m.phase if m.state in MOVING else "")
        moving = float(m.state in MOVING)
        is_outside = getattr(m, "insertion", 0.0) < 0.0  # older recordings are all of inside
        error = math.nan if is_outside else m.rcm_error
        self._data.controller.append(time, error, m.tension, m.tension_target, m.path_speed, moving)

    def _tension(self, m: Any) -> None:
        force = m.wrench.force
        norm = math.sqrt(force.x**2 + force.y**2 + force.z**2)
        self._data.tension.append(self._time(m.header.stamp), norm)

    def _joints(self, m: Any) -> None:
        if self._data.joints is None:
            self._data.joints = SampledTable(("time", *m.name))
        if ("time", *m.name) == self._data.joints.columns:
            self._data.joints.append(self._time(m.header.stamp), *m.position)

    def _audio(self, m: Any) -> None:
        if not m.samples:
            return
        samples = np.asarray(m.samples, dtype=float)
        power = float(samples @ samples) / len(samples) / FULL_SCALE**2
        level = 10.0 * math.log10(power) if power > 0 else QUIETEST
        self._data.sound.append(self._time(m.header.stamp), max(level, QUIETEST))

    def _picture(self, m: Any) -> None:
        """Keep pictures spread over the session, never more than twice as many as are shown."""
        kept = self._data.pictures
        step = 1 << self._picture_step
        if self._picture_count % step == 0:
            kept.append(RecordedPicture(self._time(m.header.stamp), m.format, bytes(m.data)))
        self._picture_count += 1
        if len(kept) > 2 * max(self._config.pictures, 1):
            kept[:] = kept[::2]
            self._picture_step += 1

    def _diagnostics(self, m: Any) -> None:
        for status in m.status:
            level = status.level[0] if isinstance(status.level, bytes) else int(status.level)
            values = {v.key: v.value for v in status.values}
            now = NodeHealth(status.name, level, status.message, self._now, status.message, values)
            known = self._health.get(status.name)
            if known is not None and known.worst >= level:
                now = replace(known, last_message=status.message, values=values)
            self._health[status.name] = now

    def _urdf(self, m: Any) -> None:
        self._data.urdf = m.data
