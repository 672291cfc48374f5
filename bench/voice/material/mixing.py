# SPDX-License-Identifier: BSD-3-Clause
"""Short clips with a background: what is said, over what, in which mode, heard by whom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Literal

import numpy as np

from bench.voice.hearing.pieces import Label, TrialChunk, in_chunks
from bench.voice.hearing.replay_stream import SoundScene, Way
from bench.voice.material import clips as voice_sets
from bench.voice.material import theatre_noise
from bench.voice.material.synthesis import SpokenClip
from support.figures import ROOT
from voice_assist.audio.mixing import add_noise, end_of_speech
from voice_assist.audio.sound_file import read_sound
from voice_assist.evaluation.evaluator import AFTER, BEFORE, QUIET_DB, read_noises
from voice_assist.types import RATE, Mode, Samples

Background = Literal["", "theatre", "servo", "speaking"]
GAPS = (0.1, 0.4)  # [s] between a word and the same word again
BACKGROUND_SECONDS = 20.0  # [s] of one piece of background
PIECES = 8  # of background, one of which is drawn for each clip
PER_CHUNK = 60  # clips: half a minute of work


@dataclass(frozen=True)
class StreamedTrial:
    """One clip as it is streamed."""

    clip: SpokenClip
    index: int  # seeds the chance in it
    again: SpokenClip | None = None  # said after a short gap
    background: Background = ""
    snr: float = 0.0  # [dB] of the speech over the background
    mode: str = Mode.ACTIVE.value
    way: Way = "both"
    is_moving: bool = False  # the robot, all the time

    def scene(self) -> tuple[Label, SoundScene]:
        """What to stream, and what is known of it."""
        sound, end, seconds = stream_of(self)
        label: Label = {**asdict(self.clip), "end": end, "seconds": seconds}
        spans = ((0.0, len(sound) / RATE),) if self.background == "speaking" else ()
        mode, moves = Mode(self.mode), self.is_moving
        return label, SoundScene(sound, mode, way=self.way, is_moving=moves, robot_speaks=spans)


def chunks(trials: Sequence[StreamedTrial], is_whole: bool = False) -> list[TrialChunk]:
    """Trials in pieces; whole: all of them, whatever SHARE says."""
    is_moving = any(trial.is_moving for trial in trials)
    return in_chunks(trials, PER_CHUNK, is_moving, is_whole)


def trials_of(clips: Sequence[SpokenClip]) -> list[StreamedTrial]:
    """Each clip once, in quiet, armed."""
    return [StreamedTrial(clip, index) for index, clip in enumerate(clips)]


def twice(clips: Sequence[SpokenClip]) -> list[StreamedTrial]:
    """Each clip followed by another of the same voice and text, or by itself where it has none."""
    following: dict[SpokenClip, SpokenClip] = {}
    groups: dict[tuple[str, str, str], list[SpokenClip]] = {}
    for clip in clips:
        groups.setdefault((clip.engine, clip.voice, clip.text), []).append(clip)
    for group in groups.values():
        following.update(zip(group, [*group[1:], group[0]], strict=True))
    return [replace(trial, again=following[trial.clip]) for trial in trials_of(clips)]


def stream_of(trial: StreamedTrial) -> tuple[Samples, float, float]:
    """Sound of a trial, the end of the first word's speech in it and the clip's length [s]."""
    rng = np.random.default_rng(trial.index)
    first = read_sound(ROOT / trial.clip.path)
    end = BEFORE + end_of_speech(first)
    speech = first
    if trial.again is not None:
        gap = np.zeros(round(rng.uniform(*GAPS) * RATE), np.float32)
        speech = np.concatenate([first, gap, read_sound(ROOT / trial.again.path)])
    quiet = 10.0 ** (QUIET_DB / 20.0)
    stream = quiet * rng.standard_normal(round((BEFORE + AFTER) * RATE) + len(speech))
    start = round(BEFORE * RATE)
    stream[start : start + len(speech)] += speech
    if trial.background:
        pieces = _backgrounds(trial.background)
        piece = pieces[int(rng.integers(len(pieces)))]
        stream = add_noise(stream, piece, first, trial.snr, rng)
    return np.asarray(stream, np.float32), end, len(speech) / RATE


_PIECES: dict[str, list[Samples]] = {}  # per process, since making them takes seconds


def _backgrounds(kind: Background) -> list[Samples]:
    if kind not in _PIECES:
        if kind == "theatre":
            _PIECES[kind] = read_noises(voice_sets.theatre())
        else:
            seeds = range(100, 100 + PIECES)
            _PIECES[kind] = [theatre_noise.make(kind, BACKGROUND_SECONDS, seed) for seed in seeds]
    return _PIECES[kind]
