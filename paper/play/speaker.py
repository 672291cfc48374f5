# SPDX-License-Identifier: BSD-3-Clause
"""Phrases in a synthetic voice, each repetition with a rate and a pitch of its own."""

from __future__ import annotations

import shutil
import subprocess
from collections import deque
from dataclasses import dataclass
from random import Random
from typing import cast

import numpy as np
from numpy.typing import NDArray

from paper.config import ExperimentConfig, PaperVoiceConfig
from support.theatre_sound import levelled
from voice_assist.training.data import voices

PROGRAMS = {
    **{"espeak": "espeak-ng", "phonemes": "espeak-ng", "mbrola": "mbrola", "flite": "flite"},
    **{"festival": "festival", "rhvoice": "RHVoice-test", "pico": "pico2wave"},
}
PROBE = "hey robot"
AHEAD = 8  # phrases that are synthesised at once


@dataclass(frozen=True, eq=False)
class SpokenPhrase:
    """One phrase as it is played."""

    words: str
    samples: NDArray[np.float32]  # (n,), 16 kHz mono in [-1, 1]
    rate: float  # relative speed
    pitch: float  # [0, 1]


class Speaker:
    """Speaks phrases; no two alike."""

    def __init__(self, voice: PaperVoiceConfig, config: ExperimentConfig, seed: int) -> None:
        self.voice = voice
        self._config, self._rng = config, Random(f"{seed} {voice.name}")
        self._ready: dict[str, deque[SpokenPhrase]] = {}

    def prepare(self, words: str, count: int) -> None:
        """Synthesise a phrase so many times ahead.

        Raises:
            RuntimeError: The voice gave no sound.
        """
        styles = [
            (self._rng.uniform(*self._config.rate), self._rng.uniform(*self._config.pitch))
            for _ in range(count)
        ]
        engine = cast(voices.Engine, self.voice.engine)
        prompts = [voices.Prompt(words, engine, self.voice.voice, *style) for style in styles]
        spoken = [
            SpokenPhrase(words, levelled(sound.astype(np.float32) / np.float32(32768)), *style)
            for sound, style in zip(voices.speak(prompts), styles, strict=True)
            if sound is not None
        ]
        if not spoken:
            raise RuntimeError(f"the voice {self.voice.name} gave no sound for {words!r}")
        self._ready.setdefault(words, deque()).extend(spoken)

    def say(self, words: str) -> SpokenPhrase:
        """Return the next repetition of a phrase."""
        if not self._ready.get(words):
            self.prepare(words, AHEAD)
        return self._ready[words].popleft()


def installed_voices(config: ExperimentConfig) -> frozenset[str]:
    """Names of the voices that can speak on this machine."""
    return frozenset(voice.name for voice in config.voices if _speaks(voice))


def _speaks(voice: PaperVoiceConfig) -> bool:
    if shutil.which(PROGRAMS[voice.engine]) is None:
        return False
    engine = cast(voices.Engine, voice.engine)
    try:
        sounds = voices.speak([voices.Prompt(PROBE, engine, voice.voice, 1.0, 0.5)])
    except (OSError, ValueError, subprocess.CalledProcessError):
        return False
    return sounds[0] is not None
