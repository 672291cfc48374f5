# SPDX-License-Identifier: BSD-3-Clause
"""Runs labelled clips through the node's own pipeline and counts what came of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import soundfile
from numpy.random import Generator

from voice_assist.audio.mixing import add_noise, end_of_speech
from voice_assist.audio.sound_file import check_sound, read_sound
from voice_assist.audio.source import FRAME, Framer
from voice_assist.config import CommandsConfig, VoiceConfig
from voice_assist.errors import AudioError, ManifestError
from voice_assist.intent.mapper import Mapper
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.text.csv_rows import csv_rows
from voice_assist.text.normalize import contains, normalize
from voice_assist.types import RATE, Match, Mode, Samples, UtteranceDecision

MOVING = "moving"  # active, while the robot moves
MODES = (Mode.ACTIVE.value, Mode.STANDBY.value, MOVING)  # in which clips may be heard
BEFORE = 0.5  # [s] of quiet in front of a clip
AFTER = 1.5  # [s] of quiet behind it, so that its end can be heard
QUIET_DB = -75.0  # [dB] of full scale of that quiet
# Ends of names. Other files are of sound where their first bytes are.
_SOUNDS = (".aac", ".aif", ".aiff", ".flac", ".m4a", ".mp3", ".oga", ".ogg", ".opus", ".wav")


@dataclass(frozen=True)
class LabelledClip:
    """One row of a manifest."""

    row: int  # in the file, the header is row 1
    path: Path
    transcript: str
    phrase: str  # command it should be taken for; empty: none


@dataclass(frozen=True)
class Taken:
    """One command taken from a clip."""

    command: str
    latency: float  # [s] from the end of speech in the clip to the decision; below 0: before it
    confidence: float


@dataclass(frozen=True)
class ClaimedCommand:
    """A decision whose words are exactly a command's, taken or refused."""

    command: str
    confidence: float  # [0, 1] that the decision carried
    origin: str  # "recognizer" or "spotter"
    is_taken: bool


@dataclass(frozen=True)
class ClipOutcome:
    """What a clip came to."""

    clip: LabelledClip
    seconds: float  # of the clip, without the quiet around it
    taken: tuple[Taken, ...]
    heard: tuple[str, ...]  # transcripts of all decisions, refused ones too
    why: tuple[str, ...]  # reasons of those refused
    compute: float  # [s]
    streamed: float  # [s] of sound, with the quiet around it
    claims: tuple[ClaimedCommand, ...] = ()


class StreamClock:
    """Time of a stream that is processed on one core as it comes in, however fast it really goes.

    A frame is there when its last sample is, and is worked on as soon as the work before it is
    done; the clock then runs as the work does. So a decision's stamp is stream time plus compute.
    """

    def __init__(self, timer: Callable[[], float] = time.perf_counter) -> None:
        """Start at 0 s.

        Args:
            timer: Measures the work [s].
        """
        self._timer = timer
        self._base = 0.0
        self._started: float | None = None
        self.compute = 0.0  # [s] of work so far

    def __call__(self) -> float:
        """Stream time now [s]."""
        worked = 0.0 if self._started is None else self._timer() - self._started
        return self._base + worked

    def begin(self, arrived: float) -> None:
        """A frame that was complete at a stream time [s] is worked on."""
        self._base = max(self._base, arrived)
        self._started = self._timer()

    def end(self) -> None:
        """The work on it is done."""
        now = self()
        self.compute += now - self._base
        self._base, self._started = now, None


class Evaluator:
    """Streams clips through one pipeline."""

    def __init__(
        self,
        make_pipeline: Callable[[Callable[[], float]], Pipeline],
        mode: str,
        noises: Sequence[Samples] = (),
        snr_db: float = 0.0,
        timer: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Build the pipeline.

        Args:
            make_pipeline: Builds it from a clock.
            mode: One of MODES, in which every clip is heard, whatever was said in it before.
            noises: One of them, chosen by the row, is added to each clip.
            snr_db: Level of the clip's speech above the noise [dB].
            timer: Measures the work [s].
        """
        self._clock = StreamClock(timer)
        self._pipeline = make_pipeline(self._clock)
        self._is_moving = mode == MOVING
        self._mode = Mode.ACTIVE if self._is_moving else Mode(mode)
        self._noises, self._snr_db = noises, snr_db

    def __call__(self, clip: LabelledClip) -> ClipOutcome:
        """Stream one clip.

        Raises:
            ManifestError: Its sound cannot be read.
        """
        try:
            samples = read_sound(clip.path)
        except AudioError as error:
            raise ManifestError(f"row {clip.row}: {error}") from error
        speech_end = BEFORE + end_of_speech(samples)
        rng = np.random.default_rng(clip.row)
        stream = surrounded(samples, rng, self._noises, self._snr_db, whole=FRAME)
        began, compute = self._clock() + 1.0, self._clock.compute
        taken, heard, why, claims = [], [], [], []
        self._pipeline.reset()
        for decision in self._decide(stream, began):
            heard.append(decision.hypothesis.text)
            claims += claims_of(decision)
            if isinstance(decision.outcome, Match):
                latency = decision.decided - began - speech_end
                taken.append(Taken(decision.outcome.command, latency, decision.confidence))
            else:
                why.append(decision.outcome.rejection.words)
        spent = self._clock.compute - compute
        seconds = len(samples) / RATE
        streamed = len(stream) / RATE
        words = tuple(heard), tuple(why)
        return ClipOutcome(clip, seconds, tuple(taken), *words, spent, streamed, tuple(claims))

    def warm_up(self) -> None:
        """Let torch compile and allocate what it does only once, so that no clip pays for it."""
        rng = np.random.default_rng(0)
        loud = 0.2 * rng.standard_normal(2 * RATE).astype(np.float32)
        for _ in self._decide(loud, self._clock() + 1.0):
            pass
        self._pipeline.warm_up(loud)

    def _decide(self, stream: Samples, began: float) -> Iterator[UtteranceDecision]:
        for frame in Framer().push(stream, began):
            self._pipeline.set_mode(self._mode, "evaluation")
            self._clock.begin(frame.end)
            events = self._pipeline(replace(frame, is_moving=self._is_moving))
            self._clock.end()
            yield from (event for event in events if isinstance(event, UtteranceDecision))


def surrounded(
    samples: Samples,
    rng: Generator,
    noises: Sequence[Samples] = (),
    snr_db: float = 0.0,
    around: tuple[float, float] = (BEFORE, AFTER),
    whole: int = 1,
) -> Samples:
    """A clip amid quiet.

    Args:
        samples: Shape (n,).
        rng: Source of chance.
        noises: One of them is added.
        snr_db: Level of the clip's speech above it [dB].
        around: Quiet in front of the clip and behind it [s].
        whole: The length is a multiple of so many samples.

    Returns:
        Shape (m,), m > n.
    """
    length = round(sum(around) * RATE) + len(samples)
    stream = 10.0 ** (QUIET_DB / 20.0) * rng.standard_normal(-(-length // whole) * whole)
    start = round(around[0] * RATE)
    stream[start : start + len(samples)] += samples
    if noises:
        noise = noises[int(rng.integers(len(noises)))]
        stream = add_noise(stream, noise, samples, snr_db, rng)
    return np.asarray(stream, np.float32)


def said_once(config: VoiceConfig) -> VoiceConfig:
    """The settings with each motion taken at once, since a clip says it once."""
    return replace(config, commands=replace(config.commands, said_twice=False))


def read_manifest(
    path: str | Path, commands: CommandsConfig, mode: str = Mode.ACTIVE.value
) -> list[LabelledClip]:
    """Rows of a manifest, all checked.

    Args:
        path: CSV with the columns `path` (relative to the manifest) and `transcript`.
        commands: Tell which transcripts are commands.
        mode: One of MODES. A command that does not count in it is none. While the robot moves, a
            halt among other words is one, too.

    Raises:
        ManifestError: The file or a row of it cannot be used; all that is wrong is named.
    """
    path, mapper = Path(path), Mapper(commands)
    counted = Mode.ACTIVE.value if mode == MOVING else mode
    phrases = {
        mapper.words(spelling): phrase
        for phrase, spellings in mapper.accepted().items()
        for spelling in spellings
        if counted in commands.get(phrase).modes
    }
    halts = [c.phrase for c in commands.commands if c.is_halt] if mode == MOVING else []
    clips, problems = [], []
    for row, (name, transcript) in csv_rows(path, "path", "transcript"):
        words = mapper.words(transcript)
        halt = next((halt for halt in halts if contains(words, normalize(halt))), "")
        try:
            clips.append(_clip(path.parent, row, name, transcript, halt or phrases.get(words, "")))
        except (AudioError, ManifestError) as error:
            problems.append(f"row {row}: {error}")
    _refuse(path, "rows", problems)
    if not clips:
        raise ManifestError(f"{path}: has no rows below its header")
    return clips


def noise_files(folder: str | Path) -> list[Path]:
    """All sound files of a folder and its subfolders, sorted by name.

    Raises:
        ManifestError: There is no such folder, or no sound file in it.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise ManifestError(f"{folder}: {'not a folder' if folder.exists() else 'no such folder'}")
    found = [path for path in sorted(folder.rglob("*")) if path.is_file() and _is_sound(path)]
    if not found:
        raise ManifestError(f"{folder}: no sound files in it")
    return found


def read_noises(folder: str | Path) -> list[Samples]:
    """The sound of `noise_files`.

    Raises:
        ManifestError: As `noise_files`, or one cannot be read, or is silent; all are named.
    """
    noises, problems = [], []
    for path in noise_files(folder):
        try:
            noises.append(read_sound(path))
        except AudioError as error:
            problems.append(str(error))
            continue
        if not noises[-1].any():
            problems.append(f"{path}: silent, so no level of noise can be made of it")
    _refuse(Path(folder), "sound files", problems)
    return noises


def _is_sound(path: Path) -> bool:
    """Whether a file is of sound by its name or its first bytes; it may be damaged."""
    if path.suffix.lower() in _SOUNDS:
        return True
    try:
        soundfile.info(str(path))
    except (soundfile.LibsndfileError, RuntimeError):
        return False
    return True


def _refuse(path: Path, what: str, problems: Sequence[str]) -> None:
    if problems:
        shown = "\n  ".join(problems[:10])
        more = f"\n  and {len(problems) - 10} more" if len(problems) > 10 else ""
        raise ManifestError(f"{path}: {len(problems)} {what} cannot be used\n  {shown}{more}")


def _clip(folder: Path, row: int, name: str, transcript: str, phrase: str) -> LabelledClip:
    if not name.strip():
        raise ManifestError("the path is empty")
    path = folder / name.strip()
    check_sound(path)
    return LabelledClip(row, path, transcript, phrase)


def claims_of(decision: UtteranceDecision) -> list[ClaimedCommand]:
    """The claim of a decision whose words are exactly a command's; of any other none."""
    outcome, sure = decision.outcome, decision.confidence
    if isinstance(outcome, Match):
        return [ClaimedCommand(outcome.command, sure, decision.decided_by, True)]
    if outcome.wer.get(outcome.nearest_command) != 0.0:
        return []
    return [ClaimedCommand(outcome.nearest_command, sure, decision.decided_by, False)]
