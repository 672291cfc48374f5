# SPDX-License-Identifier: BSD-3-Clause
"""Words under which another person talks, and two commands in the same moment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from random import Random
from typing import Literal

import numpy as np

from bench.common.resumable import digest, share_of
from bench.voice.hearing.fingerprint import identity_in_motion, outline
from bench.voice.hearing.pieces import MODEL, Label
from bench.voice.hearing.replay_stream import SoundScene, Way
from bench.voice.material.over_talk import at_peak, gain_below, over_talk
from bench.voice.material.synthesis import SpokenClip
from support.figures import ROOT
from voice_assist.audio.mixing import end_of_speech
from voice_assist.audio.sound_file import read_sound
from voice_assist.types import RATE, Mode, Samples

Kind = Literal["under talk", "at once", "talk alone"]
AROUND = 1.5, 1.5  # [s] of the talk before the word and behind it
QUIET = 0.8  # [s] before and behind two commands
PER_CHUNK = 40  # trials: some two minutes of sound


@dataclass(frozen=True)
class OverlapTrial:
    """A word, and what another voice says meanwhile."""

    kind: Kind
    clip: SpokenClip  # the word; of talk alone the talk
    other: SpokenClip | None  # who talks, or the other command
    level: float  # [dB] of the word over the other voice, each while it speaks
    index: int  # seeds the chance in it
    is_moving: bool
    way: Way = "both"


@dataclass(frozen=True)
class OverlapChunk:
    """Some trials in one piece."""

    trials: tuple[OverlapTrial, ...]

    def name(self) -> str:
        """Digest of all that is streamed, and of how a robot that moves is listened for."""
        sound, _ = stream_of(self.trials[0])
        plan = [astuple(trial) for trial in self.trials]
        return digest(plan, outline(sound), identity_in_motion(MODEL))

    def scenes(self) -> Iterator[tuple[Label, SoundScene]]:
        """One per trial."""
        for trial in self.trials:
            sound, end = stream_of(trial)
            clip, other = trial.clip, trial.other
            label: Label = {
                "text": clip.text,
                "engine": clip.engine,
                "voice": clip.voice,
                "path": clip.path,
                "other": other.path if other else "",
                "end": end,
                "seconds": len(sound) / RATE,
            }
            yield label, SoundScene(sound, Mode.ACTIVE, way=trial.way, is_moving=trial.is_moving)


def overlap_chunks(trials: Sequence[OverlapTrial]) -> list[OverlapChunk]:
    """Trials in pieces, SHARE of them; in an order by chance, so that a part is like the whole."""
    mixed = list(trials)
    Random(0).shuffle(mixed)
    some = share_of(mixed)
    return [OverlapChunk(tuple(some[i : i + PER_CHUNK])) for i in range(0, len(some), PER_CHUNK)]


def stream_of(trial: OverlapTrial) -> tuple[Samples, float]:
    """Sound of a trial, shape (n,), and when the word in it ends [s]."""
    rng = np.random.default_rng(trial.index)
    word = _spoken(trial.clip)
    if trial.other is None:
        return at_peak(word), len(word) / RATE
    other = _spoken(trial.other)
    if trial.kind == "under talk":
        return over_talk(word, other, trial.level, rng, AROUND)
    begin = round(QUIET * RATE)
    sound = np.zeros(max(len(word), len(other)) + 2 * begin)
    sound[begin:][: len(other)] = gain_below(word, other, trial.level) * other
    sound[begin:][: len(word)] += word
    return at_peak(sound), QUIET + end_of_speech(word)


def _spoken(clip: SpokenClip) -> Samples:
    return read_sound(ROOT / clip.path)
