# SPDX-License-Identifier: BSD-3-Clause
"""The word "stop" said over a spoken answer of the product, and the answers alone."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cache

import numpy as np

from bench.voice.hearing.pieces import Label
from bench.voice.hearing.replay_stream import SoundScene
from bench.voice.material.over_talk import gain_below
from bench.voice.material.synthesis import SpokenClip
from support.figures import ROOT
from typed_config import load_file
from voice_assist.answers.voices import choose_voice
from voice_assist.audio.mixing import end_of_speech
from voice_assist.audio.sound_file import read_sound
from voice_assist.config.alarms import FILE, AlarmsConfig
from voice_assist.types import RATE, Mode, Samples

QUIET = 1.0  # [s] before and behind both
NOISE_DB = -75.0  # [dB] of full scale, of that quiet
PEAK = 0.5  # of an answer that sounds alone
PER_CHUNK = 30  # trials


@dataclass(frozen=True)
class AnswerTrial:
    """A word and the answer that is spoken meanwhile."""

    clip: SpokenClip | None  # None: the answer alone
    sentence: str  # empty: none is spoken
    level: float  # [dB] of the word over the answer, each while it speaks
    index: int  # seeds the chance in it
    is_moving: bool

    def scene(self) -> tuple[Label, SoundScene]:
        """What to stream; what the loudspeaker says is announced."""
        sound, end, spans = stream_of(self)
        label: Label = asdict(self.clip) if self.clip is not None else {}
        label |= {"text": self.sentence, "end": end, "seconds": len(sound) / RATE}
        return label, SoundScene(sound, Mode.ACTIVE, is_moving=self.is_moving, robot_speaks=spans)


def stream_of(trial: AnswerTrial) -> tuple[Samples, float, tuple[tuple[float, float], ...]]:
    """Sound of a trial, shape (n,), when its word ends [s], and from when to when it speaks [s].

    The word begins at a random place of the answer.
    """
    rng = np.random.default_rng(trial.index)
    answer = answer_sound(trial.sentence)
    word = np.zeros(0, np.float32) if trial.clip is None else read_sound(ROOT / trial.clip.path)
    begin, answer_begin = round(QUIET * RATE), round(QUIET * RATE)
    if trial.clip is not None:
        begin += int(rng.uniform(0.0, 1.0) * len(answer))
    last = max(begin + len(word), answer_begin + len(answer))
    sound = 10.0 ** (NOISE_DB / 20.0) * rng.standard_normal(last + round(QUIET * RATE))
    gain = PEAK if trial.clip is None or not trial.sentence else 1.0
    if trial.clip is not None and trial.sentence:
        gain = gain_below(word, answer, trial.level)
    sound[answer_begin:][: len(answer)] += gain * answer
    sound[begin:][: len(word)] += word
    end = (begin / RATE + end_of_speech(word)) if len(word) else 0.0
    spans = ((QUIET, QUIET + len(answer) / RATE),) if trial.sentence else ()
    return np.clip(sound, -1.0, 1.0).astype(np.float32), end, spans


@cache
def answer_sound(sentence: str) -> Samples:
    """An answer as the alarms' node says it, peak 1; empty for none."""
    if not sentence:
        return np.zeros(0, np.float32)
    return choose_voice(load_file(AlarmsConfig, FILE).speech)(sentence)
