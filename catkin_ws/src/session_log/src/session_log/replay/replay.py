# SPDX-License-Identifier: BSD-3-Clause
"""Recorded sound through the live pipeline again: the same decisions, or each difference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from session_log.errors import SessionLogError
from session_log.export.sound_stream import StreamWatch
from session_log.mcap_file.decoder import Decoder, Undecodable
from session_log.mcap_file.reader import SessionReader
from session_log.replay.compare import EXTRA, Difference, compare
from session_log.replay.config import ReplayConfig
from session_log.replay.pipeline_plugin import Decided, MakePipeline, RecordedSound, ReplayPipeline
from session_log.replay.recorded_voice import (
    RATE,
    RecordedVoice,
    SequenceWatch,
    VoiceRun,
    read_voice,
    sound_of,
)


class NoSound(SessionLogError):
    """A recording has nothing to hear; `unfit` names messages that could not be read."""

    def __init__(self, path: Path, topic: str, unfit: Sequence[str] = ()) -> None:
        super().__init__("; ".join([f"{path}: holds no sound on {topic}", *unfit]))


class ReplayFailed(SessionLogError):
    """The recorded sound, settings or model cannot be used to hear it again."""

    def __init__(self, path: Path, cause: Exception) -> None:
        super().__init__(f"{path}: cannot be heard again: {cause}")


@dataclass(frozen=True)
class SoundLoss:
    """A stretch of which the recording lacks the sound; what was decided about it is not known."""

    start: float  # [s] of the clock, end of the last sound in front of it; -inf: there is none
    end: float  # [s] of the clock, first sound behind it
    what: str


@dataclass
class ReplayResult:
    """What came of one recording."""

    path: Path
    start: float = 0.0  # [s] of the clock, first message of the session
    model: str = ""
    model_hash: str = ""
    recorded_model: str = ""
    recorded_hash: str = ""
    sound: float = 0.0  # [s] that were heard again
    recorded: int = 0  # utterances then
    heard: int = 0  # utterances now
    differences: list[Difference] = field(default_factory=list)
    losses: list[str] = field(default_factory=list)  # of the recording, in words
    warnings: list[str] = field(default_factory=list)

    @property
    def counted(self) -> list[Difference]:
        """Differences that no loss in the recording explains."""
        return [entry for entry in self.differences if not entry.excuse]

    @property
    def is_same(self) -> bool:
        """Whether everything that can be compared is the same."""
        return not self.counted


def replay(
    reader: SessionReader, config: ReplayConfig, make: MakePipeline, model: str | None = None
) -> ReplayResult:
    """Hear a recording again and compare.

    Args:
        reader: The recording, sound or not.
        config: Topics, tolerances.
        make: Builds the pipeline.
        model: Recogniser in place of the recorded one.

    Raises:
        NoSound: There is nothing to hear.
        ReplayFailed: The sound, its settings or the model cannot be used.
    """
    voice = read_voice(reader, config)
    if not voice.runs:
        raise NoSound(reader.path, config.topics.audio, voice.unfit)
    return _Replayer(reader, config, make, model, voice).run()


class _Replayer:
    def __init__(
        self,
        reader: SessionReader,
        config: ReplayConfig,
        make: MakePipeline,
        model: str | None,
        voice: RecordedVoice,
    ) -> None:
        self._reader, self._config, self._make, self._model = reader, config, make, model
        self._voice = voice
        self._runs = iter(voice.runs)
        self._result = ReplayResult(reader.path, voice.start, recorded=len(voice.utterances))
        self._decoder = Decoder()
        self._missing, self._stream = SequenceWatch(reader), StreamWatch()
        self._pipeline: ReplayPipeline | None = None
        self._now: list[Decided] = []
        self._unsure: list[int] = []  # of those, by identity: the node may have ended before
        self._losses: list[SoundLoss] = []
        self._end = float("-inf")  # [s] of the clock, end of the newest sound

    def run(self) -> ReplayResult:
        try:
            for message in self._reader.messages({self._config.topics.audio}):
                missing = self._missing(message)
                try:
                    sound = sound_of(self._decoder.decode(message))
                except (Undecodable, AttributeError):
                    continue
                self._hear(sound, missing)
        except (ValueError, OSError) as error:
            raise ReplayFailed(self._reader.path, error) from error
        return self._conclude()

    def _hear(self, sound: RecordedSound, missing: int) -> None:
        is_new, lost = self._stream(sound.first_sample, len(sound.samples))
        if is_new or self._pipeline is None:
            if (run := next(self._runs, None)) is None:
                raise ValueError("it grew while it was read: the voice node began another run")
            self._pipeline = self._begin(run)
        if lost:
            self._lose(self._pipeline, sound, lost, is_new, missing)
        decided = self._pipeline.hear(sound)
        if not self._pipeline.heard_live(sound.first_sample):
            self._unsure += map(id, decided)
        self._now += decided
        self._end = sound.stamp + len(sound.samples) / sound.rate
        self._result.sound += len(sound.samples) / sound.rate

    def _begin(self, run: VoiceRun) -> ReplayPipeline:
        pipeline = self._make(run.settings, run.notes, self._model)
        result, facts = self._result, run.facts
        result.model, result.model_hash = pipeline.model, pipeline.model_hash
        result.recorded_model = facts.get("model", "")
        result.recorded_hash = facts.get("model_sha256", "")
        found = [*pipeline.warnings]
        if self._model is None:
            found += _other(f"model {pipeline.model!r}", result.recorded_hash, pipeline.model_hash)
        spotter = facts.get("spotter_sha256", "")
        if pipeline.spotter_hash:
            found += _other("the spotter's model", spotter, pipeline.spotter_hash)
        result.warnings += [entry for entry in found if entry not in result.warnings]
        return pipeline

    def _lose(
        self, pipeline: ReplayPipeline, sound: RecordedSound, lost: int, is_new: bool, missing: int
    ) -> None:
        """Sound is missing; unless it was already for the live pipeline, what follows is unsure."""
        has_known = pipeline.lost_live(sound.first_sample)
        if has_known or not (is_new or missing or self._voice.has_notes):
            return
        where = "before the first" if is_new else "in front of sample"
        words = f"{lost / RATE:.2f} s of sound {where} {sound.first_sample}"
        self._losses.append(SoundLoss(self._end, sound.stamp, words))
        if change := self._voice.mode_at(sound.stamp):
            pipeline.set_mode(change.mode, change.reason)

    def _conclude(self) -> ReplayResult:
        result, voice = self._result, self._voice
        result.heard = len(self._now)
        found = compare(voice.utterances, self._now, self._config)
        result.differences = self._excuse(found)
        result.losses = [*self._damage(), *(loss.what for loss in self._losses)]
        return result

    def _damage(self) -> list[str]:
        voice, condition = self._voice, self._reader.condition
        words = [str(damage) for damage in condition.damage]
        lost = sum(entry.lost_before for entry in voice.utterances)
        for count, what in (
            (lost, "utterances that were recorded"),
            (voice.lost_notes, "notes of what hearing depended on"),
        ):
            if count:
                words.append(f"{count} {what}")
        return [*words, *voice.unfit]

    def _excuse(self, found: Sequence[Difference]) -> list[Difference]:
        left = [entry.lost_before for entry in self._voice.utterances]
        excused = []
        for entry in found:
            reason = self._excuse_by_time(entry)
            is_extra = entry.kinds == (EXTRA,)
            if not reason and is_extra and entry.number < len(left) and left[entry.number]:
                left[entry.number] -= 1
                reason = "its record is lost"
            excused.append(replace(entry, excuse=reason))
        return excused

    def _excuse_by_time(self, entry: Difference) -> str:
        for loss in self._losses:
            if loss.start <= entry.decision <= loss.end + self._config.settling:
                return f"{loss.what} is lost"
        if entry.kinds != (EXTRA,):
            return ""
        if self._voice.has_notes:
            is_last = id(entry.now) in self._unsure
            return "the node may have ended before it had heard so far" if is_last else ""
        is_last = entry.decision > self._end - self._config.tail
        return "the recording ends there" if is_last else ""


def _other(what: str, then: str, now: str) -> list[str]:
    """A warning where a model is not the recorded one."""
    if not then:
        return [f"{what}: which one it was is not recorded; now it is {now[:12]}"]
    if then == now:
        return []
    return [f"{what} is another than the recorded one: {now[:12]}, recorded {then[:12]}"]
