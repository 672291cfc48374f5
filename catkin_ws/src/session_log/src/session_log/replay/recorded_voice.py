# SPDX-License-Identifier: BSD-3-Clause
"""What a recording holds of what was heard: runs of the voice node, utterances, modes, notes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from session_log.export.sound_stream import StreamWatch
from session_log.mcap_file.decoder import Decoder, MissingField, Undecodable
from session_log.mcap_file.reader import SessionReader
from session_log.recording.metadata import PARAMETERS, settings_at
from session_log.replay.config import ReplayConfig
from session_log.replay.pipeline_plugin import RecordedSound
from session_log.types import Message, MessageSource

RATE = 16_000  # [Hz] of all recorded sound


@dataclass(frozen=True)
class RecordedDecision:
    """One recorded decision; times in [s] of the clock."""

    transcript: str
    wer: Mapping[str, float]
    command: str
    reason: str
    nearest_command: str
    confidence: float
    mode: str
    decided_by: str
    is_partial: bool
    speech_start: float
    speech_end: float
    decision: float
    lost_before: int = 0  # records of utterances in front of it that are not in the file


@dataclass(frozen=True)
class ModeChange:
    """The voice mode from a time on."""

    time: float  # [s] of the clock
    mode: str
    reason: str


@dataclass
class VoiceRun:
    """One run of the voice node: its sound begins at sample 0."""

    settings: Mapping[str, Any] = field(default_factory=dict)  # empty: none were recorded
    facts: Mapping[str, str] = field(default_factory=dict)  # model, hashes
    notes: list[str] = field(default_factory=list)  # what hearing depended on other than the sound


@dataclass
class RecordedVoice:
    """All that a replay needs but the sound itself."""

    start: float = 0.0  # [s] of the clock, first message of the session
    runs: list[VoiceRun] = field(default_factory=list)
    utterances: list[RecordedDecision] = field(default_factory=list)
    modes: list[ModeChange] = field(default_factory=list)
    has_notes: bool = False  # the node was one that says what hearing depended on
    lost_notes: int = 0
    undecodable: int = 0
    missing_fields: set[str] = field(default_factory=set)  # what was recorded without which field

    @property
    def unfit(self) -> list[str]:
        """What of it could not be read, in words."""
        words = f"{self.undecodable} messages that do not fit their definition"
        return [*([words] if self.undecodable else []), *sorted(self.missing_fields)]

    def mode_at(self, time: float) -> ModeChange | None:
        """The recorded mode at a time of the clock [s]."""
        before = [change for change in self.modes if change.time <= time]
        return before[-1] if before else None


class SequenceWatch:
    """Counts messages that were received and are not in the file."""

    def __init__(self, reader: SessionReader) -> None:
        self._reader = reader
        self._previous: dict[MessageSource, int] = {}

    def __call__(self, message: Message) -> int:
        """How many of its source are missing right before a message."""
        previous = self._previous.get(message.source, 0)
        self._previous[message.source] = message.sequence
        is_numbered = self._reader.condition.is_numbered
        return max(message.sequence - previous - 1, 0) if is_numbered else 0


def read_voice(reader: SessionReader, config: ReplayConfig) -> RecordedVoice:
    """Read all of it in one pass, without keeping the sound."""
    return _VoiceReader(reader, config).run()


class _VoiceReader:
    def __init__(self, reader: SessionReader, config: ReplayConfig) -> None:
        topics = config.topics
        self._reader, self._config = reader, config
        self._decoder = Decoder()
        self._missing = SequenceWatch(reader)
        self._stream = StreamWatch()
        self._voice = RecordedVoice()
        self._held_notes: list[str] = []  # the next sound shows which run they are of
        self._next_sample = 0  # after the newest sound
        self._parameters: Mapping[str, str] = {}  # as of the newest sound
        self._facts: Mapping[str, str] = {}  # as of the newest sound
        self._takers = {
            topics.audio: self._audio,
            topics.utterance: self._utterance,
            topics.mode: self._mode,
            topics.circumstances: self._note,
        }

    def run(self) -> RecordedVoice:
        voice = self._voice
        for message in self._reader.messages():
            voice.start = voice.start or message.log_time * 1e-9
            take = self._takers.get(message.source.topic)
            if take is None:
                continue
            try:
                missing = self._missing(message)
                self._decoder.read(message, partial(take, missing=missing))
            except MissingField as error:
                voice.missing_fields.add(str(error))
            except (Undecodable, AttributeError):
                voice.undecodable += 1
        self._note_condition()  # nothing that came after the newest sound is of a further run
        self._end_run()
        return voice

    def _audio(self, content: Any, missing: int) -> None:
        first, length = content.first_sample, len(content.samples)
        is_new, _lost = self._stream(first, length)
        if is_new:
            self._end_run(first)
            self._voice.runs.append(VoiceRun())
        self._voice.runs[-1].notes += self._held_notes
        self._held_notes, self._next_sample = [], first + length
        self._note_condition()

    def _utterance(self, m: Any, missing: int) -> None:
        self._voice.utterances.append(
            RecordedDecision(
                transcript=m.transcript,
                wer=dict(zip(m.phrases, m.wer, strict=False)),
                command=m.command,
                reason=m.reason,
                nearest_command=m.nearest_command,
                confidence=float(m.confidence),
                mode=m.mode,
                decided_by=m.decided_by,
                is_partial=bool(m.is_partial),
                speech_start=m.speech_start.to_sec(),
                speech_end=m.speech_end.to_sec(),
                decision=m.decision.to_sec(),
                lost_before=missing,
            )
        )

    def _mode(self, m: Any, missing: int) -> None:
        self._voice.modes.append(ModeChange(m.header.stamp.to_sec(), m.mode, m.reason))

    def _note(self, m: Any, missing: int) -> None:
        self._voice.has_notes = True
        self._voice.lost_notes += missing
        self._held_notes.append(m.data)

    def _note_condition(self) -> None:
        """Keep what is known now: before its first sound, the next run records its own."""
        condition = self._reader.condition
        self._parameters = condition.latest(PARAMETERS)
        self._facts = condition.latest(self._config.facts)

    def _end_run(self, first_sample: int = 0) -> None:
        """Complete the newest run; the next one is heard from this sample on."""
        if self._voice.runs:
            run, held = self._voice.runs[-1], self._held_notes
            run.settings = settings_at(self._parameters, self._config.settings)
            run.facts = self._facts
            count = _before_fall(held, self._next_sample, first_sample)
            run.notes += held[:count]
            del held[:count]


def _before_fall(notes: Sequence[str], last: int, first: int) -> int:
    """How many notes are of the run that ended: sample indices fall deepest where the next begins.

    Args:
        notes: As they came between the sound of two runs.
        last: Sample at which the sound of the first of them ended.
        first: Sample at which that of the second begins.
    """
    samples = [last]
    for note in notes:
        samples.append(_sample_of(note, samples[-1]))
    falls = [before - after for before, after in pairwise([*samples, first])]
    return falls.index(max(falls))


def _sample_of(note: str, otherwise: int) -> int:
    """The sample that a note names, if it does."""
    try:
        sample = json.loads(note)["sample"]
    except (ValueError, TypeError, KeyError):
        return otherwise
    return sample if isinstance(sample, int) else otherwise


def sound_of(content: Any) -> RecordedSound:
    """The recorded block of a decoded voice_assist/AudioChunk."""
    samples = np.asarray(content.samples, np.int16)
    return RecordedSound(samples, content.rate, content.first_sample, content.header.stamp.to_sec())
