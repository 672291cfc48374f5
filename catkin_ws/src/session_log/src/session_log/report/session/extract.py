# SPDX-License-Identifier: BSD-3-Clause
"""Reads a recording once and takes from it what the report needs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from session_log.config import ReportConfig
from session_log.mcap_file.bulk import Batch
from session_log.mcap_file.decoder import Decoder, MissingField, Undecodable
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import MessageCounter, RecordingSummary
from session_log.recording.namespace import ELSEWHERE, ROOT, Namespace
from session_log.report.session.controller_words import controller_words
from session_log.report.session.fast_topics import FastTopic, LoopTopic, Take, largest_of_each
from session_log.report.session.joint_peaks import JointPeaks
from session_log.report.session.joint_tables import JointTables
from session_log.report.session.session_data import (
    DEVICES,
    MOVING,
    SILENT,
    IntendedPhrase,
    Intervals,
    NodeHealth,
    RecordedEvent,
    RecordedPicture,
    RecordedTrocar,
    RecordedUtterance,
    SessionData,
    Span,
    Track,
)
from session_log.report.session.stamp_clock import StampClock
from session_log.report.session.utterance_sounds import UtteranceSounds
from session_log.types import URDF_TOPIC, Message, MessageSource

FULL_SCALE = 32767.0
QUIETEST = -90.0  # [dBFS] digital silence is drawn here


def extract(reader: SessionReader, config: ReportConfig) -> SessionData:
    """Take the tables, events and pictures of a session in one pass."""
    counter = MessageCounter(reader)
    data = SessionData(RecordingSummary(reader.condition, counter.topics))
    extractor = _Extractor(data, config)
    for message in counter.messages():
        extractor.add(message)
    data.recording = counter.summary()
    extractor.finish()
    return data


class _SpanBuilder:
    """Turns a word that is reported again and again into spans."""

    def __init__(self, spans: list[Span]) -> None:
        self._spans = spans
        self._word: str | None = None
        self._since = 0.0
        self._reported = math.inf  # [s] when a word that comes again and again came last

    def add_all(self, times: Track, words: NDArray[Any]) -> None:
        """Add words in order of time, shape (n,) each; the same again changes nothing.

        They come again and again, so silence ends a span.
        """
        before = np.concatenate([[self._reported], times[:-1]])
        is_silent = times - before > SILENT
        is_change = np.concatenate([[True], words[1:] != words[:-1]])
        for k in np.flatnonzero(is_change | is_silent).tolist():
            if is_silent[k]:
                self.end(float(before[k]))
                self._word = None
            self.add(float(times[k]), words[k])
        self._reported = float(times[-1])

    def add(self, time: float, word: str) -> None:
        if word != self._word:
            self.end(time)
            self._word, self._since = word, time

    def finish(self, time: float, heard: float = math.inf) -> None:
        """Close what is open at the end of the recording, or when who said it fell silent.

        Args:
            time: End of the recording [s].
            heard: When who says the words gave its last sign of life in other messages [s].
        """
        last = min(self._reported, heard if heard > self._since else math.inf)
        self.end(last if time - last > SILENT else time)

    def end(self, time: float) -> None:
        if self._word is not None and time > self._since:
            self._spans.append(Span(self._since, time, self._word))


class _Extractor:
    def __init__(self, data: SessionData, config: ReportConfig) -> None:
        topics = config.topics
        self._data, self._config = data, config
        self._decoder = Decoder()
        self._origin: int | None = None  # [ns]
        self._message: Message  # that is decoded
        self._clock: StampClock  # of its stamps
        self._now = 0.0  # [s] its log time
        self._end = 0  # [ns] log time of the latest message
        self._health: dict[str, NodeHealth] = {}
        self._picture_step = self._picture_count = 0
        self._modes, self._states = _SpanBuilder(data.modes), _SpanBuilder(data.states)
        self._phases = _SpanBuilder(data.phases)
        self._loops: dict[str, dict[str, Intervals]] = {  # by topic and publisher
            topics.joint_states: {},
            topics.set_points: {},
        }
        self._slow: dict[str, Callable[[Any], None]] = {
            topics.utterance: self._utterance,
            topics.mode: self._mode,
            topics.event: self._event,
            topics.device: self._device,
            topics.picture: self._picture,
            topics.diagnostics: self._diagnostics,
            topics.intended: self._intended,
            topics.trocar: self._trocar,
            URDF_TOPIC: self._urdf,
        }
        peaks = JointPeaks(data, config)
        self._fast: dict[str, list[tuple[Take, float]]] = {
            topics.audio: [(self._audio, 0.0)],
            topics.state: [(self._state, 0.0)],
            topics.tension: [(self._tension, 0.0)],
            topics.joint_states: [(peaks.take, 0.0), (self._joints, config.sample_period)],
        }
        self._takers: dict[MessageSource, list[Callable[[Message], None]]] = {}
        self._waiting: list[FastTopic | LoopTopic] = []
        self._clocks: list[StampClock] = []
        self._joint_tables = JointTables()
        self._sounds = UtteranceSounds() if config.utterance_sound else None

    def add(self, message: Message) -> None:
        """Take what matters of one message."""
        takers = self._takers.get(message.source)
        if takers is None:
            takers = self._takers[message.source] = self._takers_of(message)
        for take in takers:
            take(message)
        self._end = message.log_time

    def finish(self) -> None:
        """Close what is open."""
        for topic in self._waiting:
            topic.flush()
        data = self._data
        data.joints, data.other_joints = self._joint_tables.best(data.urdf)
        for table in (data.controller, data.tension, data.sound, data.rcm_peaks, data.joints):
            if table is not None:  # each source of a topic adds its rows in blocks
                table.sort()
        self._name_callers()
        self._data.clock_offsets = dict(filter(None, (clock.offset for clock in self._clocks)))
        end = self._relative(self._end)
        sound = self._data.sound["time"]
        self._modes.finish(end, float(sound[-1]) if len(sound) else math.inf)
        for words in (self._states, self._phases):
            words.finish(end)
        if self._sounds is not None:
            self._data.sounds = self._sounds.finish()
        self._data.health = sorted(self._health.values(), key=lambda h: h.name)
        for loops in self._loops.values():
            for publisher, loop in loops.items() if len(loops) > 1 else ():
                loop.topic += f" ({publisher or 'unnamed'})"
            self._data.loops += [loop for loop in loops.values() if loop.length]

    def _name_callers(self) -> None:
        """Give callers the names that publishers have, and phrases those of the controller."""
        data, condition = self._data, self._data.recording.condition
        home = Namespace(condition.latest("session").get("namespace", ROOT))
        data.events = [replace(e, caller=home.recorded(e.caller)) for e in data.events]
        data.called = controller_words(condition, sorted({h.publisher for h in data.heard}))

    def _takers_of(self, message: Message) -> list[Callable[[Message], None]]:
        source, topic = message.source, message.source.topic
        if self._origin is None:
            self._origin = message.log_time
        if not source.is_ros1:
            is_known = topic in self._loops or topic in self._fast or topic in self._slow
            return [self._count_unfit] if is_known else []
        found: list[FastTopic | LoopTopic] = []
        if topic in self._loops:
            loop = self._loops[topic].setdefault(source.publisher, Intervals(topic))
            found.append(LoopTopic(source, loop))
        clock = StampClock(source, self._data.clock_lags)
        self._clocks.append(clock)
        for take, period in self._fast.get(topic, ()):
            found.append(FastTopic(source, clock, take, self._data, self._origin, period))
        self._waiting += found
        takers: list[Callable[[Message], None]] = [waiting.add for waiting in found]
        if topic in self._slow:
            takers.append(partial(self._decode, self._slow[topic], clock))
        return takers

    def _count_unfit(self, message: Message) -> None:
        self._data.undecodable[message.source.topic] += 1

    def _decode(self, take: Callable[[Any], None], clock: StampClock, message: Message) -> None:
        self._message, self._clock = message, clock
        self._now = self._relative(message.log_time)
        try:
            self._decoder.read(message, take)
        except MissingField as error:
            self._data.missing_fields.add(str(error))
        except (Undecodable, AttributeError, ValueError, IndexError):
            self._count_unfit(message)

    def _relative(self, stamp: int) -> float:
        return (stamp - (self._origin or 0)) * 1e-9

    def _time(self, stamp: Any) -> float:
        """Time of a message's stamp [s]; that of its arrival if it was not set."""
        return self._times(stamp)[0]

    def _times(self, *stamps: Any) -> list[float]:
        """Times of a message's stamps [s], the last of which says when it was sent."""
        known = np.array([stamp.to_nsec() for stamp in stamps], np.int64)
        arrival = np.array([self._message.log_time], np.int64)
        times = self._clock.in_log_time(known, arrival, known[-1:])
        return [self._relative(time) for time in times.tolist()]

    def _utterance(self, m: Any) -> None:
        wer = dict(zip(m.phrases, m.wer, strict=False))
        self._data.phrases = tuple(dict.fromkeys((*self._data.phrases, *m.phrases)))
        start, end, decision = self._times(m.speech_start, m.speech_end, m.decision)
        heard = RecordedUtterance(
            speech_start=start,
            speech_end=end,
            decision=decision,
            transcript=m.transcript,
            command=m.command,
            reason=m.reason,
            nearest_command=m.nearest_command,
            wer=float(wer.get(m.command or m.nearest_command, math.nan)),
            is_partial=bool(m.is_partial),
            publisher=self._message.source.publisher,
        )
        self._data.heard.append(heard)
        if self._sounds is not None:
            self._sounds.want(heard)

    def _intended(self, m: Any) -> None:
        self._data.intended.append(IntendedPhrase(self._now, m.data))

    def _trocar(self, m: Any) -> None:
        position = (m.point.x, m.point.y, m.point.z)
        self._data.trocars.append(RecordedTrocar(self._now, position, m.header.frame_id))

    def _mode(self, m: Any) -> None:
        self._modes.add(max(self._time(m.header.stamp), 0.0), m.mode)

    def _event(self, m: Any) -> None:
        time, code = self._time(m.header.stamp), getattr(m, "reason_code", "")
        self._data.events.append(
            RecordedEvent(time, m.kind, m.command, m.message, code, getattr(m, "caller", ""))
        )

    def _device(self, m: Any) -> None:
        time, kind = self._time(m.header.stamp), "accepted" if m.is_done else "refused"
        words = ", ".join(filter(None, (m.target, m.message)))
        self._data.device_calls.append(RecordedEvent(time, kind, m.phrase, words, caller=DEVICES))

    def _state(self, batch: Batch, time: Track) -> None:
        state = batch.column("state")
        moving = np.isin(state, MOVING)
        self._states.add_all(time, state)
        self._phases.add_all(time, np.where(moving, batch.column("phase"), ""))
        error = batch.column("rcm_error")
        if "insertion" in batch.names:  # older recordings are all of inside
            error = np.where(batch.column("insertion") < 0.0, np.nan, error)
        tension, target = batch.column("tension"), batch.column("tension_target")
        self._data.controller.extend(time, error, tension, target, moving)

    def _tension(self, batch: Batch, time: Track) -> None:
        force = np.column_stack([batch.column(f"wrench.force.{axis}") for axis in "xyz"])
        tension = np.linalg.norm(force, axis=1)
        kept = largest_of_each(time, tension, self._config.sample_period)
        self._data.tension.extend(time[kept], tension[kept])

    def _joints(self, batch: Batch, time: Track) -> None:
        self._joint_tables.add(time, batch.lists("name"), batch.column("position"))

    def _audio(self, batch: Batch, time: Track) -> None:
        samples = [np.asarray(block, np.int16) for block in batch.column("samples")]
        if self._sounds is not None and "rate" in batch.names:
            self._sounds.hear(time, samples, int(batch.column("rate")[0]))
        blocks = [block.astype(float) for block in samples]
        power = np.array([b @ b / max(len(b), 1) for b in blocks]) / FULL_SCALE**2
        level = 10.0 * np.log10(np.maximum(power, 10.0 ** (QUIETEST / 10.0)))
        has_sound = np.array([len(block) > 0 for block in blocks])
        self._data.sound.extend(time[has_sound], level[has_sound])

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
        is_elsewhere = self._message.source.publisher.endswith(ELSEWHERE)
        for status in m.status:
            name = status.name + ELSEWHERE * is_elsewhere
            level = status.level[0] if isinstance(status.level, bytes) else int(status.level)
            values = {v.key: v.value for v in status.values}
            now = NodeHealth(name, level, status.message, self._now, status.message, values)
            known = self._health.get(name)
            if known is not None and known.severity >= now.severity:
                now = replace(known, last_message=status.message, values=values)
            self._health[name] = now

    def _urdf(self, m: Any) -> None:
        self._data.urdf = m.data
