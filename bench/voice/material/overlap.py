# SPDX-License-Identifier: BSD-3-Clause
"""Words under which another person talks, and two commands in the same moment."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Literal

import numpy as np

from bench.voice.hearing.pieces import Label
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

    def scene(self) -> tuple[Label, SoundScene]:
        """What to stream, and what is known of it."""
        sound, end = stream_of(self)
        other = self.other.path if self.other else ""
        label: Label = {**asdict(self.clip), "other": other, "end": end}
        label["seconds"] = len(sound) / RATE
        return label, SoundScene(sound, Mode.ACTIVE, way=self.way, is_moving=self.is_moving)


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
